//! The board: clocks, pins, rates, and what the machine can do. To port the image, change this file.
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

use splineway::output::{Analogue, EdgeTimes, Scale, StepDir, StepTiming};
use splineway::{AxisLimits, AxisTravel, Config, Coord, Limits, Travel};
use stm32f4xx_hal::gpio::{self, Edge, ErasedPin, Input, PushPull};
use stm32f4xx_hal::pac::{Peripherals, TIM1, TIM3, USART2};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc;
use stm32f4xx_hal::serial::{self, Rx, Serial, Tx};
use stm32f4xx_hal::timer::{CounterHz, Event, PwmChannel};
use stm32f4xx_hal::watchdog::IndependentWatchdog;

/// Axes.
pub const AXES: usize = 3;
/// Rate of the step timer, Hz.
pub const STEP_HZ: u32 = 100_000;
/// Servo cycles per second, 1000 to 10,000.
pub const SERVO_HZ: u32 = 1_000;
/// Ticks of the step timer per servo cycle.
pub const TICKS: u32 = STEP_HZ / SERVO_HZ;
/// Bits per second on the serial line.
const BAUD: u32 = 921_600;
/// Time without a sign of life from the background after which the chip is reset, ms. A planning step
/// may take a tenth of a second.
pub const WATCHDOG_MS: u32 = 1_000;
/// Steps per nanometres: 400 steps/mm.
const SCALE: (u32, u32) = (400, 1_000_000);
/// Pulse, pause, set-up and hold, ns: common drives ask for 2500, 2500, 5000 and 5000 at most.
const DRIVE: EdgeTimes = EdgeTimes { pulse: 2_500, pause: 2_500, setup: 5_000, hold: 5_000 };
/// Velocity of every axis, mm/s.
const VELOCITY: f32 = 100.0;
/// Acceleration, mm/s2.
const ACCELERATION: f32 = 1_000.0;
/// Jerk, mm/s3.
const JERK: f32 = 20_000.0;
/// How far the axes may go from where they stand when the board is switched on: there is no homing. `Some` of a
/// coordinate is a limit.
const TRAVEL: [AxisTravel; AXES] = [AxisTravel { least: None, greatest: None }; AXES];
/// Speed along the path that gives a full duty cycle, mm/s.
const FULL_DUTY: f32 = 200.0;

const _: () = assert!(SERVO_HZ >= 1_000 && SERVO_HZ <= 10_000 && STEP_HZ.is_multiple_of(SERVO_HZ));

pub type Output = ErasedPin<gpio::Output<PushPull>>;
pub type Stepper = StepDir<Output, Output>;
pub type Laser = Analogue<PwmChannel<TIM1, 0>, f32>;

/// What the core is told of the machine.
pub fn config() -> Config<f32, AXES> {
    let axis = AxisLimits::linear(VELOCITY, ACCELERATION, JERK);
    let limits = defmt::unwrap!(Limits::new([axis; AXES]), "limits");
    let mut config = Config::new(limits);
    config.travel = defmt::unwrap!(Travel::new(TRAVEL), "limits of travel");
    config.cycle = 1.0 / SERVO_HZ as f32;
    // Longer than a planning step takes at 168 MHz with flash wait states.
    config.lead = 0.05;
    config
}

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
    let scale = defmt::unwrap!(Scale::new(SCALE.0, SCALE.1), "scale");
    let timing = StepTiming::from_ns(STEP_HZ, 1_000_000 / SERVO_HZ, DRIVE);
    // Rounded up, and one for the rounding of the setpoints.
    let per_mm = SCALE.0 as f32 * 1.0e6 / SCALE.1 as f32;
    let most = (VELOCITY * per_mm / SERVO_HZ as f32) as u32 + 2;
    match StepDir::new(step, dir, scale, timing, Coord::ZERO, most) {
        Ok(stepper) => stepper,
        Err(_) => defmt::panic!(
            "{} steps per servo cycle at full speed, {} fit into one: a faster step timer, or fewer steps per mm",
            most,
            timing.most_steps()
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
        let mut input = |mut pin: ErasedPin<Input>| {
            // Open - pressed, or a broken wire - is high.
            pin.make_interrupt_source(&mut syscfg);
            pin.trigger_on_edge(&mut device.EXTI, Edge::Rising);
            pin.enable_interrupt(&mut device.EXTI);
            pin
        };
        let stop_button = input(c.pc4.into_pull_up_input().erase());
        let switches = [
            input(c.pc6.into_pull_up_input().erase()),
            input(c.pc7.into_pull_up_input().erase()),
            input(c.pc8.into_pull_up_input().erase()),
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
