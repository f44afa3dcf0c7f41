//! The tasks.

use defmt_rtt as _;
use panic_probe as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use crate::board::{self, Board, Laser, Output, Stepper};
    use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
    use heapless::spsc::{Consumer, Producer, Queue};
    use splineway::wire::{Command, Event, Events};
    use splineway::{
        BLOCKS, Controls, Coord, Interpolator, Link, NODES, Planner, Progress, Setpoint,
    };
    use splineway_controller::{Background, Clock, Port};
    use stm32f4xx_hal::gpio::{ErasedPin, Input};
    use stm32f4xx_hal::pac::{Interrupt, TIM3, USART2};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::serial::{Rx, Tx};
    use stm32f4xx_hal::timer::{CounterHz, Flag};
    use stm32f4xx_hal::watchdog::IndependentWatchdog;

    const AXES: usize = board::AXES;
    /// Items that wait for the planner: the host's window.
    const WINDOW: usize = 16;
    /// Events that may be on their way to the servo task.
    const QUEUED: usize = 8;
    /// Bytes that may arrive while the planner works: more than a window of the longest frames.
    const BYTES: usize = 4096;

    /// The emergency stop has been hit; stays so until reset.
    static EMERGENCY: AtomicBool = AtomicBool::new(false);
    /// A limit switch has been hit and the host has not been told.
    static LIMIT: AtomicBool = AtomicBool::new(false);
    /// An axis did not make all steps of a cycle.
    static LAGGED: AtomicBool = AtomicBool::new(false);
    /// Bytes lost because there was no room.
    static LOST: AtomicU32 = AtomicU32::new(0);
    /// Servo cycles since the start: the background's clock.
    static CYCLES: AtomicU32 = AtomicU32::new(0);
    /// Spindle, coolant, tool: from the line to the servo task.
    static EVENTS: Events<QUEUED> = Events::new();

    #[shared]
    struct Shared {
        /// Where the axes are to be at the end of the next servo cycle.
        targets: [Coord; AXES],
        /// The last setpoint, for reports.
        setpoint: Setpoint<f32, AXES>,
        /// Enables the drives.
        enable: Output,
    }

    #[local]
    struct Local {
        steppers: [Stepper; AXES],
        step_timer: CounterHz<TIM3>,
        interpolator: Interpolator<'static, f32, AXES>,
        laser: Laser,
        rx: Rx<USART2>,
        bytes_in: Producer<'static, u8>,
        bytes_out: Consumer<'static, u8>,
        tx: Tx<USART2>,
        planner: Planner<'static, f32, AXES>,
        stop_button: ErasedPin<Input>,
        switches: [ErasedPin<Input>; AXES],
        stop_controls: Controls<'static>,
        limit_controls: Controls<'static>,
        watchdog: IndependentWatchdog,
        led: Output,
    }

    #[init(local = [
        link: Link<f32, AXES> = Link::new(),
        bytes: Queue<u8, BYTES> = Queue::new(),
    ])]
    fn init(context: init::Context) -> (Shared, Local) {
        let board = Board::new(context.device);
        // An input that is open already gives no edge.
        EMERGENCY.store(board.stop_button.is_high(), Relaxed);
        let start = [Coord::ZERO; AXES];
        let made = context.local.link.split(board::config(), start);
        let (planner, mut interpolator) = defmt::unwrap!(made, "the settings cannot be used");
        let (bytes_in, bytes_out) = context.local.bytes.split();
        let setpoint = interpolator.tick();
        let controls = planner.controls();
        defmt::info!("splineway {}: {} axes", env!("CARGO_PKG_VERSION"), AXES);
        (
            Shared { targets: start, setpoint, enable: board.enable },
            Local {
                steppers: board.steppers,
                step_timer: board.step_timer,
                interpolator,
                laser: board.laser,
                rx: board.rx,
                bytes_in,
                bytes_out,
                tx: board.tx,
                planner,
                stop_button: board.stop_button,
                switches: board.switches,
                stop_controls: controls,
                limit_controls: controls,
                watchdog: board.watchdog,
                led: board.led,
            },
        )
    }

    /// One tick of every axis. At the beginning of a servo cycle the axes take the targets that the servo
    /// task has left, and it is started for the next: so steps never wait for it.
    #[task(binds = TIM3, priority = 4, local = [steppers, step_timer, tick: u32 = 0], shared = [targets])]
    fn steps(mut context: steps::Context) {
        context.local.step_timer.clear_flags(Flag::Update);
        let tick = context.local.tick;
        if *tick == 0 {
            let targets = context.shared.targets.lock(|targets| *targets);
            for (stepper, target) in context.local.steppers.iter_mut().zip(targets) {
                if stepper.begin(target) > 0 {
                    LAGGED.store(true, Relaxed);
                }
            }
            rtic::pend(Interrupt::SPI3);
        }
        *tick = if *tick + 1 < board::TICKS { *tick + 1 } else { 0 };
        for stepper in context.local.steppers.iter_mut() {
            // Pins of this chip cannot fail.
            let _ = stepper.tick();
        }
    }

    /// The servo cycle. SPI3 is not used: its interrupt stands for this task.
    #[task(binds = SPI3, priority = 3, local = [interpolator, laser], shared = [targets, setpoint])]
    fn servo(mut context: servo::Context) {
        let setpoint = context.local.interpolator.tick();
        CYCLES.store(CYCLES.load(Relaxed).wrapping_add(1), Relaxed);
        if let Some(event) = EVENTS.take(&setpoint) {
            happen(&event);
        }
        let targets = core::array::from_fn(|axis| setpoint.position(axis));
        context.shared.targets.lock(|shared| *shared = targets);
        context.shared.setpoint.lock(|shared| *shared = setpoint);
        let power = if EMERGENCY.load(Relaxed) { 0.0 } else { setpoint.path_speed };
        let _ = context.local.laser.set(power);
    }

    /// What is to be done at a place of the path. This board has nothing to switch: a machine's relays go
    /// here, or what a longer reaction is to be told by.
    fn happen(event: &Event) {
        defmt::info!("{}", event);
    }

    /// A byte from the line.
    #[task(binds = USART2, priority = 2, local = [rx, bytes_in])]
    fn receive(context: receive::Context) {
        // A noise or framing error costs this byte; the frame's CRC tells.
        if let Ok(byte) = context.local.rx.read()
            && context.local.bytes_in.enqueue(byte).is_err()
        {
            LOST.store(LOST.load(Relaxed).wrapping_add(1), Relaxed);
        }
    }

    /// The emergency stop: the drives lose their enable at once, and with it the position; only a reset
    /// brings the machine back.
    #[task(binds = EXTI4, priority = 2, local = [stop_button, stop_controls], shared = [enable])]
    fn emergency(mut context: emergency::Context) {
        context.local.stop_button.clear_interrupt_pending_bit();
        context.shared.enable.lock(|enable| enable.set_low());
        EMERGENCY.store(true, Relaxed);
        context.local.stop_controls.abort();
    }

    /// A limit switch: the machine brakes within its limits and drops the rest of the program.
    #[task(binds = EXTI9_5, priority = 2, local = [switches, limit_controls])]
    fn limit(context: limit::Context) {
        for switch in context.local.switches.iter_mut() {
            switch.clear_interrupt_pending_bit();
        }
        LIMIT.store(true, Relaxed);
        context.local.limit_controls.abort();
    }

    /// What the background sees of the board.
    struct Outside<'a, M> {
        bytes: &'a mut Consumer<'static, u8>,
        tx: &'a mut Tx<USART2>,
        setpoint: M,
        clock: Clock,
        /// Bytes lost that the log knows of.
        lost: u32,
    }

    impl<M: rtic::Mutex<T = Setpoint<f32, AXES>>> Port<f32, AXES> for Outside<'_, M> {
        fn read(&mut self) -> Option<u8> {
            self.bytes.dequeue()
        }

        fn write(&mut self, byte: u8) -> bool {
            self.tx.write(byte).is_ok()
        }

        fn now_ms(&mut self) -> u32 {
            self.clock.ms(CYCLES.load(Relaxed))
        }

        fn setpoint(&mut self) -> Setpoint<f32, AXES> {
            self.setpoint.lock(|setpoint| *setpoint)
        }

        fn alarm(&mut self) -> bool {
            let lost = LOST.load(Relaxed);
            if lost != self.lost {
                self.lost = lost;
                defmt::warn!("{} bytes came faster than they could be read", lost);
            }
            let lagged = LAGGED.swap(false, Relaxed);
            if lagged {
                defmt::error!("an axis did not make all its steps in time");
            }
            // The emergency stop lasts: no session may move anything.
            EMERGENCY.load(Relaxed) | LIMIT.swap(false, Relaxed) | lagged
        }

        fn obeyed(&mut self, command: Command) {
            defmt::debug!("command {}", command);
        }
    }

    #[idle(local = [bytes_out, tx, planner, watchdog, led], shared = [setpoint, enable])]
    fn idle(mut context: idle::Context) -> ! {
        let idle::LocalResources { bytes_out: bytes, tx, planner, watchdog, led, .. } =
            context.local;
        let clock = Clock::new(board::SERVO_HZ / 1000);
        let setpoint = context.shared.setpoint;
        let mut outside = Outside { bytes, tx, setpoint, clock, lost: 0 };
        let mut background =
            Background::<_, AXES, BLOCKS, NODES, WINDOW, QUEUED>::new(planner, &EVENTS);
        let mut progress = Progress::NeedsBlocks;
        watchdog.start(board::WATCHDOG_MS.millis());
        // Unless the emergency stop is open; asked under the lock, so that `emergency` cannot come between.
        context.shared.enable.lock(|enable| {
            if !EMERGENCY.load(Relaxed) {
                enable.set_high();
            }
        });
        loop {
            watchdog.feed();
            let now = background.round(&mut outside);
            if now != progress {
                defmt::trace!("{}", now);
                progress = now;
            }
            if progress == Progress::Planned {
                led.toggle();
            }
        }
    }
}
