//! The image: the file of frames, the text that comes out.

use crate::timer::{Timer, instructions};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use panic_semihosting as _;
use splineway::wire::Inlet;
use splineway::{BLOCKS, Link, NODES, Scalar};
use splineway_emulator::{Outcome, Setup};
use splineway_semihosting::{Bytes, File, end};

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
    end(go(), "the file cannot be read, or does not begin with a setup")
}
