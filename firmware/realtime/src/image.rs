//! The image: a timer interrupt, the frames of a file as a line that always has something, and a file of samples.

use core::cell::RefCell;
use cortex_m::interrupt::{self, Mutex};
use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use cortex_m_semihosting::hprintln;
use panic_semihosting as _;
use splineway::wire::{Events, Inlet};
use splineway::{BLOCKS, Coord, Link};
use splineway_realtime::{AXES, EVENTS, Line, Loop, Servo, Setup, round};
use splineway_semihosting::{Bytes, File, end};

/// Counts of the timers in a second, and ns of one.
const CLOCK_HZ: f32 = 25.0e6;
const COUNT: u32 = 40;
/// A timer that counts down (CMSDK APB timer): bit 0 of its control switches it on, and it begins again with its reload.
const CONTROL: *mut u32 = 0x4000_0000 as *mut u32;
const VALUE: *const u32 = 0x4000_0004 as *const u32;
const RELOAD: *mut u32 = 0x4000_0008 as *mut u32;

/// Starts the timer.
fn start_timer() {
    // SAFETY: registers of a timer that nothing else uses.
    unsafe {
        RELOAD.write_volatile(u32::MAX);
        CONTROL.write_volatile(1);
    }
}

/// ns since the start, wrapping around.
#[inline]
fn now() -> u32 {
    // SAFETY: reads a register of that timer.
    unsafe { (!VALUE.read_volatile()).wrapping_mul(COUNT) }
}

/// Nodes of the planning window, and the memory in which motion is reshaped.
#[cfg(feature = "reshape")]
mod sizes {
    use splineway::Reshaping;
    use splineway_realtime::AXES;

    pub const NODES: usize = splineway_realtime::RESHAPED_NODES;
    pub type Memory = Reshaping<f32, AXES>;
}
#[cfg(not(feature = "reshape"))]
mod sizes {
    pub const NODES: usize = splineway::NODES;
}
use sizes::NODES;

/// What the interrupt has, and what it leaves behind. Times in ns.
struct Machine {
    servo: Servo<'static>,
    samples: File,
    /// Time in the interrupt so far, wrapping around.
    spent: u32,
    /// Longest interrupt.
    worst: u32,
    /// Servo cycles that began while the one before was still served.
    missed: u32,
    /// Number of the last cycle with motion.
    moved: u32,
}

static MACHINE: Mutex<RefCell<Option<Machine>>> = Mutex::new(RefCell::new(None));

/// Looks at the machine between two interrupts.
fn with_machine<T>(look: impl FnOnce(&mut Machine) -> T) -> Option<T> {
    interrupt::free(|cs| MACHINE.borrow(cs).borrow_mut().as_mut().map(look))
}

/// A servo cycle.
#[exception]
fn SysTick() {
    let began = now();
    let _ = with_machine(|machine| {
        let sample = machine.servo.cycle();
        machine.worst = machine.worst.max(now().wrapping_sub(began));
        if !sample.idle {
            machine.moved = machine.servo.cycles;
        }
        machine.samples.write(&sample.to_bytes());
        machine.spent = machine.spent.wrapping_add(now().wrapping_sub(began));
        if cortex_m::peripheral::SCB::is_pendst_pending() {
            machine.missed += 1;
        }
    });
}

/// Instructions of a round that has found nothing to do, at most.
const IDLE: u32 = 12_500;

/// Costs of the background; times in ns, without what the interrupt took.
#[derive(Default)]
struct Cost {
    rounds: u32,
    /// A round that takes less has found nothing to do.
    short: u32,
    /// Rounds that did something, while the machine moved.
    busy: u64,
    /// The longest.
    worst: u32,
    /// Longest time from the beginning of one round to that of the next while the machine moved.
    gap: u32,
    /// When the last began.
    before: Option<u32>,
}

impl Cost {
    fn begin(&mut self, now: u32, moves: bool) {
        if let Some(before) = self.before.replace(now).filter(|_| moves) {
            self.gap = self.gap.max(now.wrapping_sub(before));
        }
    }

    fn add(&mut self, taken: u32, moves: bool) {
        self.rounds += 1;
        self.worst = self.worst.max(taken);
        // A round that finds nothing to do is waiting, not work.
        if moves && taken > self.short {
            self.busy += u64::from(taken);
        }
    }
}

/// Runs the frames, with planning that takes time. `None`: the setup cannot be used.
fn run(setup: &Setup, frames: Bytes) -> Option<()> {
    type Joined = Link<f32, AXES, BLOCKS, NODES>;
    let link: &'static mut Joined = cortex_m::singleton!(: Joined = Link::new())?;
    let events: &'static Events<EVENTS> = cortex_m::singleton!(: Events<EVENTS> = Events::new())?;
    let mut made = link.split(setup.config().ok()?, [Coord::ZERO; AXES]).ok()?;
    let (planner, interpolator) = (&mut made.0, made.1);
    #[cfg(feature = "reshape")]
    planner.reshape(cortex_m::singleton!(: sizes::Memory = sizes::Memory::new())?);
    let servo = Servo::new(interpolator, planner.controls(), events, setup);
    let samples = File::write_to(2)?;
    let machine = Machine { servo, samples, spent: 0, worst: 0, missed: 0, moved: 0 };
    interrupt::free(|cs| MACHINE.borrow(cs).replace(Some(machine)));
    let mut background = Loop::new(planner, events);
    let mut line = Line::new(frames);
    start_timer();
    let mut timer = cortex_m::Peripherals::take()?.SYST;
    timer.set_clock_source(SystClkSource::Core);
    timer.set_reload((setup.cycle * CLOCK_HZ + 0.5) as u32 - 1);
    timer.clear_current();
    timer.enable_counter();
    timer.enable_interrupt();
    let mut cost = Cost { short: setup.instruction * IDLE, ..Cost::default() };
    let complete = loop {
        let (began, spent, setpoint, cycles, moved) = with_machine(|machine| {
            let Machine { servo, spent, moved, .. } = machine;
            (now(), *spent, servo.setpoint, servo.cycles, *moved)
        })?;
        let moves = cycles < moved + 2;
        cost.begin(began, moves);
        let ms = (cycles as f32 * setup.cycle * 1000.0) as u32;
        round(&mut background, &mut line, &setpoint, ms);
        let (taken, over, done) = with_machine(|machine| {
            let taken = now().wrapping_sub(began).wrapping_sub(machine.spent.wrapping_sub(spent));
            let servo = &machine.servo;
            let over = servo.is_over() || servo.cycles >= setup.most_cycles;
            (taken, over, background.is_done(&servo.setpoint) && servo.resting > 2)
        })?;
        cost.add(taken, moves);
        if over || (done && setup.linger == 0) {
            break done;
        }
    };
    timer.disable_interrupt();
    let machine = interrupt::free(|cs| MACHINE.borrow(cs).take())?;
    let counters = made.0.counters();
    hprintln!(
        "complete={} plans={} late={} starved={} stuck={} cells={} steps={}",
        u8::from(complete),
        counters.plans,
        counters.late,
        counters.starved,
        counters.stuck,
        counters.cells,
        counters.steps,
    );
    hprintln!(
        "rounds={} busy={} worst={} gap={} tick={} missed={}",
        cost.rounds,
        cost.busy,
        cost.worst,
        cost.gap,
        machine.worst,
        machine.missed,
    );
    Some(())
}

fn go() -> Option<()> {
    let mut frames = File::read_from(1)?.bytes();
    let mut inlet = Inlet::new();
    let setup: Setup = frames.by_ref().find_map(|byte| inlet.push(byte))?;
    run(&setup, frames)
}

#[entry]
fn main() -> ! {
    end(go(), "the file cannot be read, or does not begin with a setup")
}
