//! A firmware with embassy, on an STM32F407, that had a lamp and a button; an axis was added, with a drive that takes velocities and an
//! encoder, which goes to and fro when the button is pressed. What was added stands under `Motion`; nothing of what was there has
//! changed.
//!
//! Build it, in this folder: `cargo build --release --target thumbv7em-none-eabihf`. Pins: velocity of the drive PE9 (a duty cycle of a
//! half is standstill), its enable PE8, with a resistor to ground, encoder PA5 and PB3, button PA0, lamp PD12.
#![no_std]
#![no_main]

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use embassy_executor::{InterruptExecutor, Spawner};
use embassy_futures::select::{Either, select};
use embassy_futures::yield_now;
use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{Level, Output, OutputType, Pull, Speed};
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{IWDG, TIM1, TIM2};
use embassy_stm32::time::Hertz;
use embassy_stm32::timer::low_level::CountingMode;
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm, SimplePwmChannel};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{bind_interrupts, interrupt, rcc};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::channel::Channel;
use embassy_time::{Duration, Ticker, Timer};
use panic_halt as _;
use splineway::output::{Analogue, PositionLoop};
use splineway::{
    AxisLimits, Block, Config, Coord, Interpolator, Limits, Link, Planner, Progress, PushError,
};
use static_cell::ConstStaticCell;

bind_interrupts!(struct Interrupts {
    EXTI0 => exti::InterruptHandler<interrupt::typelevel::EXTI0>;
});

/// Motion: servo cycles per second.
const SERVO_HZ: u32 = 1_000;
/// Motion: mm/s, mm/s2, mm/s3.
const LIMITS: AxisLimits<f32> = AxisLimits::linear(200.0, 2_000.0, 50_000.0);
/// Motion: velocity at which the drive's input is at its end, mm/s.
const FULL: f32 = 250.0;
/// Motion: what the encoder counts, nm.
const COUNT: i64 = 1_250;
/// Motion: 1/s; and how far the axis may be from its setpoint, mm.
const CONTROL: PositionLoop<f32> = PositionLoop { gain: 20.0, most_error: 0.5 };

/// Motion: without a servo cycle for so long, us, the chip is reset, and the drive loses its enable: it would go on with the velocity it had.
const WATCHDOG_US: u32 = 20_000;

/// Motion: planner and interpolator, and what they share.
static LINK: ConstStaticCell<Link<f32, 1>> = ConstStaticCell::new(Link::new());
/// Motion: tasks above the others, in an interrupt that is not used for anything else.
static SERVO: InterruptExecutor = InterruptExecutor::new();
/// Motion: the axis has left its setpoint, and stands still until reset.
static LOST: AtomicBool = AtomicBool::new(false);
/// Motion: where the axis is to go.
static WANTED: Channel<CriticalSectionRawMutex, Coord, 4> = Channel::new();

#[embassy_executor::task]
async fn blink(mut lamp: Output<'static>) {
    loop {
        lamp.toggle();
        Timer::after_millis(500).await;
    }
}

#[embassy_executor::task]
async fn press(mut button: ExtiInput<'static, Async>) {
    let mut forth = true;
    loop {
        button.wait_for_high().await;
        let to = if forth { 40_000_000 } else { 0 };
        forth = !forth;
        if let Ok(to) = Coord::from_nm(to) {
            WANTED.send(to).await;
        }
        // Its contact bounces, also when it is let go.
        Timer::after_millis(50).await;
        button.wait_for_low().await;
        Timer::after_millis(50).await;
    }
}

/// Motion: the servo cycle.
#[embassy_executor::task]
async fn servo(
    mut interpolator: Interpolator<'static, f32, 1>,
    encoder: Qei<'static, TIM2>,
    mut drive: Analogue<SimplePwmChannel<'static, TIM1>, f32>,
    mut enable: Output<'static>,
    mut watchdog: IndependentWatchdog<'static, IWDG>,
) {
    let mut cycle = Ticker::every(Duration::from_hz(SERVO_HZ.into()));
    let (mut counted, mut place) = (encoder.count(), 0i64);
    watchdog.unleash();
    enable.set_high();
    loop {
        cycle.next().await;
        watchdog.pet();
        let setpoint = interpolator.tick();
        let now = encoder.count();
        // Less than half of its range in a servo cycle.
        place += i64::from(now.wrapping_sub(counted) as i16);
        counted = now;
        let left = (setpoint.position_nm(0) - place * COUNT) as f32 * 1.0e-6;
        let velocity = CONTROL.velocity(setpoint.velocity[0], left);
        if velocity.is_err() {
            LOST.store(true, Relaxed);
        }
        let velocity = if LOST.load(Relaxed) { 0.0 } else { velocity.unwrap_or(0.0) };
        // A duty cycle cannot fail.
        let _ = drive.set(velocity);
    }
}

/// Motion: the background. A slice of planning takes its time, and then other tasks have theirs.
#[embassy_executor::task]
async fn motion(mut planner: Planner<'static, f32, 1>) {
    let mut next = None;
    let mut tag = 0;
    loop {
        if let Some(to) = next {
            tag += 1;
            match planner.push(&Block::line([to], 150.0, tag)) {
                Ok(()) => {
                    planner.finish();
                    next = None;
                }
                // The rest later.
                Err(PushError::Full) => {}
                Err(_) => next = None,
            }
        }
        match planner.poll() {
            Progress::Planning | Progress::Planned => yield_now().await,
            _ if next.is_some() => Timer::after_millis(1).await,
            // Until the motion has gone on, or there is more to do.
            _ => {
                if let Either::First(to) = select(WANTED.receive(), Timer::after_millis(1)).await {
                    next = Some(to);
                }
            }
        }
    }
}

#[interrupt]
unsafe fn UART4() {
    // SAFETY: it is called by this interrupt alone.
    unsafe { SERVO.on_interrupt() }
}

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let mut clocks = embassy_stm32::Config::default();
    clocks.rcc.hse = Some(rcc::Hse { freq: Hertz(8_000_000), mode: rcc::HseMode::Oscillator });
    clocks.rcc.pll_src = rcc::PllSource::HSE;
    clocks.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV4,
        mul: rcc::PllMul::MUL168,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    clocks.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    clocks.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    clocks.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    clocks.rcc.sys = rcc::Sysclk::PLL1_P;
    let p = embassy_stm32::init(clocks);
    let lamp = Output::new(p.PD12, Level::Low, Speed::Low);
    let button = ExtiInput::new(p.PA0, p.EXTI0, Pull::Down, Interrupts);

    // Motion.
    let mut config = Config::new(Limits::new([LIMITS]).expect("the limits are in their ranges"));
    config.cycle = 1.0 / SERVO_HZ as f32;
    // Longer than a planning step takes.
    config.lead = 0.05;
    let made = LINK.take().split(config, [Coord::ZERO]);
    let (planner, interpolator) = made.expect("the settings are in their ranges");
    let encoder = Qei::new(p.TIM2, p.PA5, p.PB3, qei::Config::default());
    let pin = PwmPin::new(p.PE9, OutputType::PushPull);
    let (hz, mode) = (Hertz(20_000), CountingMode::EdgeAlignedUp);
    let mut pwm = SimplePwm::new(p.TIM1, Some(pin), None, None, None, hz, mode).split().ch1;
    let half = pwm.max_duty_cycle() / 2;
    pwm.set_duty_cycle(half);
    pwm.enable();
    let enable = Output::new(p.PE8, Level::Low, Speed::Low);
    let watchdog = IndependentWatchdog::new(p.IWDG, WATCHDOG_US);
    interrupt::UART4.set_priority(Priority::P6);
    let above = SERVO.start(interrupt::UART4);
    let drive = Analogue::bipolar(pwm, FULL);
    above.spawn(servo(interpolator, encoder, drive, enable, watchdog).expect("once"));
    spawner.spawn(motion(planner).expect("once"));

    spawner.spawn(blink(lamp).expect("once"));
    spawner.spawn(press(button).expect("once"));
}
