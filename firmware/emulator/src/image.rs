//! The image: the file of frames, the timer that counts, the text that comes out.

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln, syscall};
use panic_semihosting as _;
use splineway::wire::Inlet;
use splineway::{BLOCKS, Link, NODES, Scalar};
use splineway_emulator::{Meter, Outcome, Part, Setup};

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

/// A file of the host.
struct File {
    handle: usize,
    buffer: [u8; 1024],
    next: usize,
    end: usize,
}

impl File {
    /// Opens the file that is the image's second argument.
    fn argument() -> Option<Self> {
        let mut line = [0u8; 256];
        let mut block = [line.as_mut_ptr() as usize, line.len()];
        // SAFETY: SYS_GET_CMDLINE writes at most the given length to the buffer.
        if unsafe { cortex_m_semihosting::syscall1(0x15, block.as_mut_ptr() as usize) } != 0 {
            return None;
        }
        let text = line.split(|&byte| byte == 0).next()?;
        let name = text.iter().position(|&byte| byte == b' ')? + 1;
        let length = text.len() - name;
        // SAFETY: SYS_OPEN reads a string that ends in zero, as `line` does.
        let handle = unsafe { syscall!(OPEN, line.as_ptr() as usize + name, 1, length) };
        (handle != usize::MAX).then_some(Self { handle, buffer: [0; 1024], next: 0, end: 0 })
    }

    fn byte(&mut self) -> Option<u8> {
        if self.next == self.end {
            // SAFETY: SYS_READ writes at most the given length to the buffer.
            let left = unsafe {
                syscall!(READ, self.handle, self.buffer.as_mut_ptr() as usize, self.buffer.len())
            };
            self.next = 0;
            self.end = self.buffer.len().saturating_sub(left);
        }
        let byte = *self.buffer[..self.end].get(self.next)?;
        self.next += 1;
        Some(byte)
    }
}

#[inline(never)]
fn run<S: Scalar, const N: usize, const BLOCKS: usize, const NODES: usize>(
    setup: &Setup,
    file: &mut File,
) -> Option<()> {
    let mut link = Link::<S, N, BLOCKS, NODES>::new();
    let mut timer = Timer::calibrated();
    let outcome = splineway_emulator::run::<S, N, BLOCKS, NODES>(
        &mut link,
        setup,
        &mut || file.byte(),
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
    let mut file = File::argument()?;
    let mut inlet = Inlet::new();
    let setup: Setup = loop {
        if let Some(setup) = inlet.push(file.byte()?) {
            break setup;
        }
    };
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
