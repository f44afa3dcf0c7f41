//! The image: the file of frames, the timer that counts, the text that comes out.

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use panic_semihosting as _;
use splineway::wire::Inlet;
use splineway::{BLOCKS, Link, NODES, Scalar};
use splineway_emulator::{Meter, Outcome, Part, Setup};
use splineway_semihosting::{Bytes, File};

/// Counter of TIM2. In QEMU it counts nanoseconds, and an instruction takes 64.
const COUNTER: *const u32 = 0x4000_0024 as *const u32;

#[inline]
fn now() -> u32 {
    // SAFETY: reads a register of a timer that nothing else uses.
    unsafe { COUNTER.read_volatile() }
}

/// Instructions in a time, ns.
fn instructions(ns: u64) -> u64 {
    (ns + 32) / 64
}

/// Calls, instructions in all, and of the costliest call.
#[derive(Clone, Copy, Default)]
struct Count {
    calls: u32,
    sum: u64,
    worst: u32,
}

#[derive(Default)]
struct Timer {
    began: u32,
    /// What an empty call costs, ns.
    empty: u32,
    planning: Count,
    tick: Count,
}

impl Timer {
    fn calibrated() -> Self {
        let mut timer = Self::default();
        timer.begin();
        timer.empty = now().wrapping_sub(timer.began);
        timer
    }
}

impl Meter for Timer {
    #[inline(never)]
    fn begin(&mut self) {
        self.began = now();
    }

    #[inline(never)]
    fn end(&mut self, part: Part) {
        let ns = now().wrapping_sub(self.began).saturating_sub(self.empty);
        let count = if part == Part::Tick { &mut self.tick } else { &mut self.planning };
        count.calls += 1;
        count.sum += u64::from(ns);
        count.worst = count.worst.max(ns);
    }
}

#[inline(never)]
fn run<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    setup: &Setup,
    file: &mut Bytes,
) -> Option<()> {
    let mut link = Link::<S, N, BLOCKS, NODES>::new();
    let mut timer = Timer::calibrated();
    let outcome = splineway_emulator::run::<S, N, BLOCKS, NODES>(
        &mut link,
        setup,
        &mut || file.next(),
        &mut timer,
    )
    .ok()?;
    print(&outcome, &timer);
    Some(())
}

fn print(outcome: &Outcome, timer: &Timer) {
    let Outcome { blocks, cycles, digest, complete } = *outcome;
    hprintln!(
        "blocks={} cycles={} digest={} complete={} planning={} planning_worst={} tick={} tick_worst={}",
        blocks,
        cycles,
        digest,
        u8::from(complete),
        instructions(timer.planning.sum),
        instructions(timer.planning.worst.into()),
        instructions(timer.tick.sum),
        instructions(timer.tick.worst.into()),
    );
}

fn go() -> Option<()> {
    let mut file = File::read_from(1)?.bytes();
    let mut inlet = Inlet::new();
    let setup: Setup = file.by_ref().find_map(|byte| inlet.push(byte))?;
    match setup.axes {
        3 => run::<f32, 3, BLOCKS, NODES>(&setup, &mut file),
        6 => run::<f32, 6, 8, 56>(&setup, &mut file),
        _ => None,
    }
}

#[entry]
fn main() -> ! {
    if go().is_none() {
        hprintln!("the file cannot be read, or does not begin with a setup");
        debug::exit(debug::EXIT_FAILURE);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::nop();
    }
}
