//! The board: clocks and pins. To port the image, change this file; what the machine can do is in `../machine.rs`.
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
use stm32f4xx_hal::gpio::{self, Edge, ErasedPin, Input, PushPull};
use stm32f4xx_hal::pac::{Peripherals, TIM1, TIM3, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc;
use stm32f4xx_hal::serial::{self, Rx, Serial, Tx};
use stm32f4xx_hal::timer::{CounterHz, Event, PwmChannel};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Speed along the path that gives a full duty cycle, mm/s.
const FULL_DUTY: f32 = 200.0;

/// Edges of a limit switch that are told: it opens. A sender of grbl is told when it closes, too.
const SWITCHED: Edge = if cfg!(feature = "grbl") { Edge::RisingFalling } else { Edge::Rising };

pub type Output = ErasedPin<gpio::Output<PushPull>>;
pub type Stepper = StepDir<Output, Output>;
pub type Laser = Analogue<PwmChannel<TIM1, 0>, f32>;

/// Everything, set up.
pub struct Board {
    pub steppers: [Stepper; AXES],
    pub step_timer: CounterHz<TIM3>,
    pub laser: Laser,
    pub rx: Rx<USART2>,
    pub tx: Tx<USART2>,
    pub stop_button: ErasedPin<Input>,
    pub switches: [ErasedPin<Input>; AXES],
    pub enable: Output,
    pub led: Output,
    pub watchdog: IndependentWatchdog,
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
    pub fn new(mut device: Peripherals) -> Self {
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
        let mut input = |mut pin: ErasedPin<Input>, edge| {
            // Open - pressed, or a broken wire - is high.
            pin.make_interrupt_source(&mut syscfg);
            pin.trigger_on_edge(&mut device.EXTI, edge);
            pin.enable_interrupt(&mut device.EXTI);
            pin
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
            step_timer,
            laser: Analogue::unipolar(channel, FULL_DUTY),
            rx,
            tx,
            stop_button,
            switches,
            enable: d.pd8.into_push_pull_output().erase(),
            led: d.pd12.into_push_pull_output().erase(),
            watchdog: IndependentWatchdog::new(device.IWDG),
        }
    }
}
