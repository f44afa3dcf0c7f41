//! The board: clocks, pins and interrupts. To port the image, change this file; what the machine can do is in `../machine.rs`.
//!
//! | what | pin |
//! |---|---|
//! | X step, direction | PD0, PD1 |
//! | Y step, direction | PD2, PD3 |
//! | Z step, direction | PD4, PD7 |
//! | enable of all drives (high: on) | PD8 |
//! | serial line (USART2) TX, RX | PA2, PA3 |
//! | duty cycle by the speed along the path (TIM1) | PA8 |
//! | emergency stop, normally closed to ground | PC4 |
//! | limit switches X, Y, Z, normally closed to ground | PC6, PC7, PC8 |
//! | light: toggles with every plan | PD12 |
//!
//! As on the STM32F407G-DISC1, with its crystal of 8 MHz.

use crate::machine::{self, AXES, BAUD, STEP_HZ};
use splineway::output::{Analogue, StepDir};
use stm32f4xx_hal::gpio::{self, Edge, ErasedPin, PushPull};
use stm32f4xx_hal::pac::{Peripherals, TIM1, TIM3, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc;
use stm32f4xx_hal::serial::{self, Rx, Serial, Tx};
use stm32f4xx_hal::timer::{CounterHz, Event, Flag, PwmChannel};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

pub use stm32f4xx_hal::pac;

stm32_tasks! { steps: TIM3, servo: SPI3, line: USART2, emergency: EXTI4, limit: EXTI9_5 }

/// What the core computes with: this chip has no double precision.
pub type Real = f32;

/// Speed along the path that gives a full duty cycle, mm/s.
const FULL_DUTY: Real = 200.0;

/// Edges of a limit switch that are told: it opens. A sender of grbl is told when it closes, too.
const SWITCHED: Edge = if cfg!(feature = "grbl") { Edge::RisingFalling } else { Edge::Rising };

pub type Output = ErasedPin<gpio::Output<PushPull>>;
pub type Stepper = StepDir<Output, Output>;
pub type Laser = Analogue<PwmChannel<TIM1, 0>, Real>;

/// An output that is on when it is high.
pub struct Switched(Output);

impl Switched {
    pub fn on(&mut self) {
        self.0.set_high();
    }

    pub fn off(&mut self) {
        self.0.set_low();
    }

    pub fn toggle(&mut self) {
        self.0.toggle();
    }
}

/// A contact to ground. Open - pressed, or a broken wire - is high.
pub struct Input(ErasedPin<gpio::Input>);

impl Input {
    pub fn is_open(&self) -> bool {
        self.0.is_high()
    }

    /// Its interrupt is being served.
    pub fn clear(&mut self) {
        self.0.clear_interrupt_pending_bit();
    }
}

/// The timer of the steps.
pub struct StepTimer(CounterHz<TIM3>);

impl StepTimer {
    /// Its interrupt is being served.
    #[inline]
    pub fn clear(&mut self) {
        self.0.clear_flags(Flag::Update);
    }
}

/// What the line brings.
pub struct Receiver(Rx<USART2>);

impl Receiver {
    /// The byte that has come, if one has.
    pub fn take(&mut self) -> Option<u8> {
        self.0.read().ok()
    }
}

/// What the line takes.
pub struct Transmitter(Tx<USART2>);

impl Transmitter {
    /// Whether it takes a byte.
    pub fn is_free(&self) -> bool {
        self.0.is_tx_empty()
    }

    /// Sends a byte, and asks for the next by interrupt; `None`: there is no more.
    pub fn send(&mut self, byte: Option<u8>) {
        if let Some(byte) = byte {
            let _ = self.0.write(byte);
            self.0.listen();
        } else {
            self.0.unlisten();
        }
    }
}

/// The watchdog.
pub struct Watchdog(IndependentWatchdog);

impl Watchdog {
    /// From now on it wants to be fed within so many ms.
    pub fn start(&mut self, ms: u32) {
        self.0.start(ms.millis());
    }

    #[inline]
    pub fn feed(&mut self) {
        self.0.feed();
    }
}

/// Everything, set up.
pub struct Board {
    pub steppers: [Stepper; AXES],
    pub step_timer: StepTimer,
    pub laser: Laser,
    pub receiver: Receiver,
    pub transmitter: Transmitter,
    pub stop_button: Input,
    pub switches: [Input; AXES],
    pub enable: Switched,
    pub led: Switched,
    pub watchdog: Watchdog,
}

/// Takes the drives' enable and the duty cycle away, whoever has the pins: behind a fault nobody else runs.
pub fn switch_off() {
    // SAFETY: each is one write, of what is written alone.
    let (enable, duty) = unsafe { (&*pac::GPIOD::ptr(), &*TIM1::ptr()) };
    enable.bsrr().write(|w| w.br8().reset());
    duty.ccr1().write(|w| w.ccr().set(0));
}

/// An axis that stands at zero.
fn stepper(step: Output, dir: Output) -> Stepper {
    match machine::stepper(step, dir) {
        Ok(stepper) => stepper,
        Err(_) => defmt::panic!(
            "{} steps per servo cycle at full speed do not fit: a faster step timer, or fewer steps per mm",
            machine::most_steps()
        ),
    }
}

impl Board {
    pub fn new(mut device: Peripherals, _: cortex_m::Peripherals) -> Self {
        let mut rcc = device.RCC.freeze(rcc::Config::hse(8.MHz()).sysclk(168.MHz()));
        let a = device.GPIOA.split(&mut rcc);
        let c = device.GPIOC.split(&mut rcc);
        let d = device.GPIOD.split(&mut rcc);
        let steppers = [
            stepper(d.pd0.into_push_pull_output().erase(), d.pd1.into_push_pull_output().erase()),
            stepper(d.pd2.into_push_pull_output().erase(), d.pd3.into_push_pull_output().erase()),
            stepper(d.pd4.into_push_pull_output().erase(), d.pd7.into_push_pull_output().erase()),
        ];
        let mut syscfg = device.SYSCFG.constrain(&mut rcc);
        let mut input = |mut pin: ErasedPin<gpio::Input>, edge| {
            pin.make_interrupt_source(&mut syscfg);
            pin.trigger_on_edge(&mut device.EXTI, edge);
            pin.enable_interrupt(&mut device.EXTI);
            Input(pin)
        };
        let stop_button = input(c.pc4.into_pull_up_input().erase(), Edge::Rising);
        let switches = [
            input(c.pc6.into_pull_up_input().erase(), SWITCHED),
            input(c.pc7.into_pull_up_input().erase(), SWITCHED),
            input(c.pc8.into_pull_up_input().erase(), SWITCHED),
        ];
        let line = serial::Config::default().baudrate(BAUD.bps());
        let serial: Serial<USART2> =
            defmt::unwrap!(Serial::new(device.USART2, (a.pa2, a.pa3), line, &mut rcc).ok(), "baud");
        let (tx, mut rx) = serial.split();
        rx.listen();
        let (_, (channel, ..)) = device.TIM1.pwm_hz(20.kHz(), &mut rcc);
        let mut channel = channel.with(a.pa8);
        channel.set_duty(0);
        channel.enable();
        let mut step_timer = device.TIM3.counter_hz(&mut rcc);
        defmt::unwrap!(step_timer.start(STEP_HZ.Hz()).ok(), "step timer");
        step_timer.listen(Event::Update);
        Self {
            steppers,
            step_timer: StepTimer(step_timer),
            laser: Analogue::unipolar(channel, FULL_DUTY),
            receiver: Receiver(rx),
            transmitter: Transmitter(tx),
            stop_button,
            switches,
            enable: Switched(d.pd8.into_push_pull_output().erase()),
            led: Switched(d.pd12.into_push_pull_output().erase()),
            watchdog: Watchdog(IndependentWatchdog::new(device.IWDG)),
        }
    }
}
