//! The tasks.

use defmt_rtt as _;
use panic_probe as _;

#[rtic::app(device = stm32f4xx_hal::pac, peripherals = true)]
mod app {
    use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
    use splineway::output::{EdgeTimes, Scale, StepDir, StepTiming};
    use splineway::{
        AxisLimits, Block, Config, Coord, Interpolator, Limits, Link, Planner, Progress, PushError,
    };
    use splineway_controller::{Drives, Targets};
    use stm32f4xx_hal::gpio::{Input, Output, PA0, PD0, PD1, PD12};
    use stm32f4xx_hal::pac::{Interrupt, TIM2, TIM3};
    use stm32f4xx_hal::prelude::*;
    use stm32f4xx_hal::rcc;
    use stm32f4xx_hal::timer::{CounterHz, Event, Flag};

    /// How often the button was pressed.
    static PRESSED: AtomicU32 = AtomicU32::new(0);
    /// The button is looked at so often a second: less often than its contact bounces.
    const LOOKS_HZ: u32 = 50;

    /// Motion: ticks of the step timer and servo cycles per second.
    const STEP_HZ: u32 = 100_000;
    const SERVO_HZ: u32 = 1_000;
    /// Motion: mm/s, mm/s2, mm/s3.
    const LIMITS: AxisLimits<f32> = AxisLimits::linear(100.0, 1_000.0, 20_000.0);
    /// Motion: 400 steps/mm.
    const STEPS_PER_MM: u32 = 400;

    #[shared]
    struct Shared {
        /// Motion: where the axis is to be at the end of the next servo cycle.
        targets: Targets<1>,
    }

    #[local]
    struct Local {
        lamp: PD12<Output>,
        blink: CounterHz<TIM2>,
        button: PA0<Input>,
        pressed: bool,
        // Motion.
        step_timer: CounterHz<TIM3>,
        drives: Drives<PD0<Output>, PD1<Output>, 1>,
        interpolator: Interpolator<'static, f32, 1>,
        planner: Planner<'static, f32, 1>,
    }

    #[init(local = [link: Link<f32, 1> = Link::new()])]
    fn init(context: init::Context) -> (Shared, Local) {
        let device = context.device;
        let mut rcc = device.RCC.freeze(rcc::Config::hse(8.MHz()).sysclk(168.MHz()));
        let (a, d) = (device.GPIOA.split(&mut rcc), device.GPIOD.split(&mut rcc));
        let button = a.pa0.into_pull_down_input();
        let mut blink = device.TIM2.counter_hz(&mut rcc);
        defmt::unwrap!(blink.start(LOOKS_HZ.Hz()).ok());
        blink.listen(Event::Update);

        // Motion.
        let mut config = Config::new(defmt::unwrap!(Limits::new([LIMITS]).ok()));
        config.cycle = 1.0 / SERVO_HZ as f32;
        // Longer than a planning step takes.
        config.lead = 0.05;
        let (planner, mut interpolator) =
            defmt::unwrap!(context.local.link.split(config, [Coord::ZERO]).ok());
        let drive = EdgeTimes { pulse: 2_500, pause: 2_500, setup: 5_000, hold: 5_000 };
        let timing = StepTiming::from_ns(STEP_HZ, 1_000_000 / SERVO_HZ, drive);
        let scale = defmt::unwrap!(Scale::new(STEPS_PER_MM, 1_000_000).ok());
        let most = (LIMITS.velocity * STEPS_PER_MM as f32 / SERVO_HZ as f32) as u32 + 2;
        let (step, direction) = (d.pd0.into_push_pull_output(), d.pd1.into_push_pull_output());
        let x = StepDir::new(step, direction, scale, timing, Coord::ZERO, most);
        let drives = Drives::new([defmt::unwrap!(x.ok())], STEP_HZ / SERVO_HZ);
        let targets = Targets::new(&interpolator.tick());
        let mut step_timer = device.TIM3.counter_hz(&mut rcc);
        defmt::unwrap!(step_timer.start(STEP_HZ.Hz()).ok());
        step_timer.listen(Event::Update);

        let lamp = d.pd12.into_push_pull_output();
        (
            Shared { targets },
            Local { lamp, blink, button, pressed: true, step_timer, drives, interpolator, planner },
        )
    }

    #[task(binds = TIM2, priority = 1, local = [lamp, blink, button, pressed, looks: u32 = 0])]
    fn look(context: look::Context) {
        let look::LocalResources { lamp, blink, button, pressed, looks, .. } = context.local;
        blink.clear_flags(Flag::Update);
        *looks += 1;
        if *looks == LOOKS_HZ / 4 {
            *looks = 0;
            lamp.toggle();
        }
        // One that is pressed when the board is switched on has not been pressed.
        if !core::mem::replace(pressed, button.is_high()) && *pressed {
            PRESSED.store(PRESSED.load(Relaxed).wrapping_add(1), Relaxed);
        }
    }

    /// Motion: above all other tasks. A servo cycle begins with the targets that the servo task has left, and starts it for the next.
    #[task(binds = TIM3, priority = 4, local = [step_timer, drives], shared = [targets])]
    fn steps(mut context: steps::Context) {
        context.local.step_timer.clear_flags(Flag::Update);
        // Pins of this chip cannot fail.
        let Ok(beat) = context.local.drives.tick(|| context.shared.targets.lock(|shared| *shared));
        if beat.lagged {
            defmt::panic!("the axis did not make all its steps in time");
        }
        if beat.tick == 0 {
            rtic::pend(Interrupt::SPI3);
        }
    }

    /// Motion: the servo cycle. SPI3 is not used: its interrupt stands for this task.
    #[task(binds = SPI3, priority = 3, local = [interpolator], shared = [targets])]
    fn servo(mut context: servo::Context) {
        let targets = Targets::new(&context.local.interpolator.tick());
        context.shared.targets.lock(|shared| *shared = targets);
    }

    /// Motion: the background. Each time the button is pressed the axis goes to 40 mm, or back.
    #[idle(local = [planner])]
    fn idle(context: idle::Context) -> ! {
        let idle::LocalResources { planner, .. } = context.local;
        let ends = [0, 40_000_000].map(|nm| defmt::unwrap!(Coord::from_nm(nm).ok()));
        let (mut pushed, mut forth) = (0u32, true);
        loop {
            if pushed != PRESSED.load(Relaxed) {
                let to = ends[usize::from(forth)];
                match planner.push(&Block::line([to], 80.0, pushed)) {
                    Ok(()) => {
                        planner.finish();
                        pushed = pushed.wrapping_add(1);
                        forth = !forth;
                    }
                    // The rest later.
                    Err(PushError::Full) => {}
                    Err(error) => defmt::panic!("{}", error),
                }
            }
            let progress = planner.poll();
            if progress != Progress::Planning && progress != Progress::Planned {
                // The step timer wakes it.
                cortex_m::asm::wfi();
            }
        }
    }
}
