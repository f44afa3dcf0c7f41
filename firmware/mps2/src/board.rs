//! The board: clocks and pins.

use crate::device::{CLOCK_HZ, DUAL, Half, TIMER, UART, Uart, WATCHDOG};
use crate::machine::{self, AXES};
use core::convert::Infallible;
use core::sync::atomic::{AtomicU8, Ordering::Relaxed};
use embedded_hal::digital::{ErrorType, OutputPin};
use splineway::output::StepDir;
use splineway_mps2::pins::{self, Levels, Recorder};

/// What the core computes with.
#[cfg(feature = "f64")]
pub type Real = f64;
/// What the core computes with.
#[cfg(not(feature = "f64"))]
pub type Real = f32;

/// Levels of the output pins.
static LEVELS: AtomicU8 = AtomicU8::new(0);

/// An output pin: some bits of the port.
pub struct Pin(Levels);

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    #[inline]
    fn set_low(&mut self) -> Result<(), Infallible> {
        LEVELS.fetch_and(!self.0, Relaxed);
        Ok(())
    }

    #[inline]
    fn set_high(&mut self) -> Result<(), Infallible> {
        LEVELS.fetch_or(self.0, Relaxed);
        Ok(())
    }
}

pub type Stepper = StepDir<Pin, Pin>;

/// What hangs on the pins: writes down what they do.
pub struct Port(Recorder);

impl Port {
    /// After a tick of the step timer.
    #[inline]
    pub fn tick(&mut self, tick: u32) {
        let [_, out, ..] = &UART;
        self.0.tick(tick, LEVELS.load(Relaxed), |byte| out.data.write(byte.into()));
    }
}

/// Writes down that inputs have changed, after a tick of the step timer.
pub fn note_edge(tick: u32) {
    let [_, out, ..] = &UART;
    // The record of the pins does not come in between.
    cortex_m::interrupt::free(|_| {
        out.data.write(pins::EDGE.into());
        out.data.write(tick);
    });
}

/// Whether a byte of the record was lost.
pub fn is_record_damaged() -> bool {
    let [_, out, ..] = &UART;
    out.state.read() & 4 != 0
}

/// The receiver of the line. The emulator gives a byte as soon as the one before has been read, whatever the baud rate;
/// so a byte is read when it would have come.
pub struct Receiver(());

/// A byte begins to come from the line: its time begins.
#[inline]
pub fn byte_begins() {
    let ([line, ..], [half, _]) = (&UART, &DUAL);
    line.pending.write(2);
    half.load.write(BYTE);
}

impl Receiver {
    /// The byte that has come, if one has.
    #[inline]
    pub fn take(&mut self) -> Option<u8> {
        let ([line, ..], [half, _]) = (&UART, &DUAL);
        if half.pending.read() & 1 == 0 {
            return None;
        }
        half.clear.write(1);
        Some(line.data.read() as u8)
    }
}

/// The transmitter of the line; a byte takes as long as at the baud rate.
pub struct Transmitter {
    busy: bool,
}

impl Transmitter {
    /// Whether it takes a byte.
    #[inline]
    pub fn is_free(&mut self) -> bool {
        let [_, half] = &DUAL;
        if self.busy && half.pending.read() & 1 != 0 {
            half.clear.write(1);
            self.busy = false;
        }
        !self.busy
    }

    /// Sends a byte.
    #[inline]
    pub fn send(&mut self, byte: u8) {
        let ([line, ..], [_, half]) = (&UART, &DUAL);
        line.data.write(byte.into());
        half.load.write(BYTE);
        self.busy = true;
    }
}

/// The input pins.
pub struct Inputs(());

impl Inputs {
    /// Their levels from now on.
    #[inline]
    pub fn take(&mut self) -> u8 {
        let [.., input] = &UART;
        input.pending.write(2);
        input.data.read() as u8
    }
}

/// The step timer.
pub struct StepTimer(());

impl StepTimer {
    /// Its interrupt is being served.
    #[inline]
    pub fn clear(&mut self) {
        let [timer, _] = &TIMER;
        timer.pending.write(1);
    }
}

/// The watchdog.
pub struct Watchdog(());

impl Watchdog {
    /// From now on it wants to be fed.
    pub fn start(&mut self) {
        // It resets when it has come to zero twice.
        WATCHDOG.load.write(CLOCK_HZ / 2000 * machine::WATCHDOG_MS);
        WATCHDOG.control.write(3);
    }

    /// A sign of life.
    #[inline]
    pub fn feed(&mut self) {
        WATCHDOG.clear.write(1);
    }
}

/// Time since the start, in units of [`TIME_NS`], wrapping around.
#[inline]
pub fn now() -> u32 {
    let [_, timer] = &TIMER;
    !timer.value.read()
}

/// ns.
pub const TIME_NS: u32 = 1_000_000_000 / CLOCK_HZ;

/// Time of a byte on the line - start, eight bits, stop -, in cycles of the clock, rounded up.
const BYTE: u32 = (10 * CLOCK_HZ).div_ceil(machine::BAUD);

/// Everything, set up.
pub struct Board {
    pub steppers: [Stepper; AXES],
    pub port: Port,
    pub step_timer: StepTimer,
    pub enable: Pin,
    pub receiver: Receiver,
    pub transmitter: Transmitter,
    pub inputs: Inputs,
    pub watchdog: Watchdog,
}

/// Turns a port on; `control` has its interrupts.
fn open(uart: &Uart, control: u32) {
    uart.divider.write(CLOCK_HZ / machine::BAUD);
    uart.control.write(3 | control);
}

/// Makes half of the dual timer an alarm clock.
fn alarm_clock(half: &Half) {
    // Once, 32 bits, interrupt, begins with what is loaded, on.
    half.control.write(1 | 2 | 0x20 | 0x40);
    half.clear.write(1);
    half.control.write(1 | 2 | 0x20 | 0x40 | 0x80);
}

impl Board {
    /// `None`: the steps of the machine do not fit into the rate of the timer.
    pub fn new() -> Option<Self> {
        let [line, record, log, inputs] = &UART;
        open(line, 8);
        open(record, 0);
        open(log, 0);
        open(inputs, 8);
        for half in &DUAL {
            alarm_clock(half);
        }
        let [steps, free] = &TIMER;
        free.reload.write(u32::MAX);
        free.value.write(u32::MAX);
        free.control.write(1);
        let stepper =
            |axis| machine::stepper(Pin(pins::step(axis)), Pin(pins::direction(axis))).ok();
        let steppers = [stepper(0)?, stepper(1)?, stepper(2)?];
        steps.reload.write(CLOCK_HZ / machine::STEP_HZ - 1);
        steps.value.write(CLOCK_HZ / machine::STEP_HZ - 1);
        steps.control.write(9);
        Some(Self {
            steppers,
            port: Port(Recorder::new()),
            step_timer: StepTimer(()),
            enable: Pin(pins::ENABLE),
            receiver: Receiver(()),
            transmitter: Transmitter { busy: false },
            inputs: Inputs(()),
            watchdog: Watchdog(()),
        })
    }
}

const _: () =
    assert!(machine::TICKS <= pins::MOST_TICKS && CLOCK_HZ.is_multiple_of(machine::STEP_HZ));
