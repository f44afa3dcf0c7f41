//! The board: clocks, pins and interrupts. To port the image, change this file; what the machine can do is in `../machine.rs`.
//!
//! | what | pin |
//! |---|---|
//! | X step, direction | PD0, PD1 |
//! | Y step, direction | PD2, PD3 |
//! | Z step, direction | PD4, PD7 |
//! | enable of all drives (high: on) | PE4 |
//! | serial line (USART3) TX, RX: the virtual port of the board's ST-LINK | PD8, PD9 |
//! | duty cycle by the speed along the path (TIM1) | PE9 |
//! | emergency stop, normally closed to ground | PG0 |
//! | limit switches X, Y, Z, normally closed to ground | PF7, PF8, PF9 |
//! | light: toggles with every plan | PB0 |
//!
//! As on the NUCLEO-H743ZI2, whose ST-LINK gives a clock of 8 MHz.

use crate::machine::{self, AXES, BAUD, STEP_HZ};
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use embedded_hal::pwm::{self, SetDutyCycle};
use splineway::output::{Analogue, StepDir};
use stm32h7xx_hal::gpio::{self, Edge, ErasedPin, ExtiPin, PushPull};
use stm32h7xx_hal::independent_watchdog::IndependentWatchdog;
use stm32h7xx_hal::pac::{Peripherals, TIM1, TIM3, USART3};
use stm32h7xx_hal::prelude::*;
use stm32h7xx_hal::pwm::{ComplementaryDisabled, Pwm};
use stm32h7xx_hal::serial::config::Config;
use stm32h7xx_hal::serial::{Rx, Tx};
use stm32h7xx_hal::timer::{Event, Timer};

pub use stm32h7xx_hal::pac;

stm32_tasks! { steps: TIM3, servo: SPI3, line: USART3, emergency: EXTI0, limit: EXTI9_5 }

/// What the core computes with.
#[cfg(feature = "f64")]
pub type Real = f64;
/// What the core computes with.
#[cfg(not(feature = "f64"))]
pub type Real = f32;

/// Speed along the path that gives a full duty cycle, mm/s.
const FULL_DUTY: Real = 200.0;

/// Edges of a limit switch that are told: it opens. A sender of grbl is told when it closes, too.
const SWITCHED: Edge = if cfg!(feature = "grbl") { Edge::RisingFalling } else { Edge::Rising };

pub type Stepper = StepDir<Output, Output>;
pub type Laser = Analogue<Duty, Real>;

/// An output pin.
pub struct Output(ErasedPin<gpio::Output<PushPull>>);

impl ErrorType for Output {
    type Error = Infallible;
}

impl OutputPin for Output {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0.set_low();
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0.set_high();
        Ok(())
    }
}

/// A duty cycle.
pub struct Duty(Pwm<TIM1, 0, ComplementaryDisabled>);

impl pwm::ErrorType for Duty {
    type Error = Infallible;
}

impl SetDutyCycle for Duty {
    fn max_duty_cycle(&self) -> u16 {
        self.0.get_max_duty()
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.0.set_duty(duty);
        Ok(())
    }
}

/// An output that is on when it is high.
pub struct Switched(ErasedPin<gpio::Output<PushPull>>);

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
pub struct StepTimer(Timer<TIM3>);

impl StepTimer {
    /// Its interrupt is being served.
    #[inline]
    pub fn clear(&mut self) {
        self.0.clear_irq();
    }
}

/// What the line brings.
pub struct Receiver(Rx<USART3>);

impl Receiver {
    /// The byte that has come, if one has.
    pub fn take(&mut self) -> Option<u8> {
        self.0.read().ok()
    }
}

/// What the line takes.
pub struct Transmitter(Tx<USART3>);

impl Transmitter {
    /// Whether it takes a byte.
    pub fn is_free(&self) -> bool {
        self.0.is_txe()
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
    let (enable, duty) = unsafe { (&*pac::GPIOE::ptr(), &*TIM1::ptr()) };
    enable.bsrr.write(|w| w.br4().reset());
    duty.ccr1().write(|w| w.ccr().bits(0));
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
    pub fn new(mut device: Peripherals, mut core: cortex_m::Peripherals) -> Self {
        let power = device.PWR.constrain().freeze();
        let rcc = device.RCC.constrain().use_hse(8.MHz()).bypass_hse().sys_ck(400.MHz());
        let ccdr = rcc.freeze(power, &device.SYSCFG);
        // Code and constants are in flash, which is slower; nothing but the processor writes to memory.
        core.SCB.enable_icache();
        core.SCB.enable_dcache(&mut core.CPUID);
        let b = device.GPIOB.split(ccdr.peripheral.GPIOB);
        let d = device.GPIOD.split(ccdr.peripheral.GPIOD);
        let e = device.GPIOE.split(ccdr.peripheral.GPIOE);
        let f = device.GPIOF.split(ccdr.peripheral.GPIOF);
        let g = device.GPIOG.split(ccdr.peripheral.GPIOG);
        let steppers = [
            stepper(
                Output(d.pd0.into_push_pull_output().erase()),
                Output(d.pd1.into_push_pull_output().erase()),
            ),
            stepper(
                Output(d.pd2.into_push_pull_output().erase()),
                Output(d.pd3.into_push_pull_output().erase()),
            ),
            stepper(
                Output(d.pd4.into_push_pull_output().erase()),
                Output(d.pd7.into_push_pull_output().erase()),
            ),
        ];
        let mut input = |mut pin: ErasedPin<gpio::Input>, edge| {
            pin.make_interrupt_source(&mut device.SYSCFG);
            pin.trigger_on_edge(&mut device.EXTI, edge);
            pin.enable_interrupt(&mut device.EXTI);
            Input(pin)
        };
        let stop_button = input(g.pg0.into_pull_up_input().erase(), Edge::Rising);
        let switches = [
            input(f.pf7.into_pull_up_input().erase(), SWITCHED),
            input(f.pf8.into_pull_up_input().erase(), SWITCHED),
            input(f.pf9.into_pull_up_input().erase(), SWITCHED),
        ];
        let pins = (d.pd8.into_alternate(), d.pd9.into_alternate());
        let line = Config::default().baudrate(BAUD.bps());
        let serial = device.USART3.serial(pins, line, ccdr.peripheral.USART3, &ccdr.clocks);
        let (tx, mut rx) = defmt::unwrap!(serial.ok(), "baud").split();
        rx.listen();
        let pin = e.pe9.into_alternate();
        let mut duty = device.TIM1.pwm(pin, 20.kHz(), ccdr.peripheral.TIM1, &ccdr.clocks);
        duty.set_duty(0);
        duty.enable();
        let timer = device.TIM3;
        let mut step_timer = timer.timer(STEP_HZ.Hz(), ccdr.peripheral.TIM3, &ccdr.clocks);
        step_timer.listen(Event::TimeOut);
        Self {
            steppers,
            step_timer: StepTimer(step_timer),
            laser: Analogue::unipolar(Duty(duty), FULL_DUTY),
            receiver: Receiver(rx),
            transmitter: Transmitter(tx),
            stop_button,
            switches,
            enable: Switched(e.pe4.into_push_pull_output().erase()),
            led: Switched(b.pb0.into_push_pull_output().erase()),
            watchdog: Watchdog(IndependentWatchdog::new(device.IWDG)),
        }
    }
}
