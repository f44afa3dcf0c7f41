//! The image: the file with the spline, the text that comes out.

use crate::timer::{Timer, instructions};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use panic_semihosting as _;
use splineway_emulator::smoothing::{Smoothed, smooth};
use splineway_semihosting::{File, end};

fn go() -> Option<()> {
    let mut file = File::read_from(1)?.bytes();
    let mut timer = Timer::calibrated();
    let Smoothed { points, iterations, digest } = smooth(&mut || file.next(), &mut timer)?;
    hprintln!(
        "points={} iterations={} digest={} instructions={}",
        points,
        iterations,
        digest,
        instructions(timer.planning.sum),
    );
    Some(())
}

#[entry]
fn main() -> ! {
    end(go(), "the file cannot be read, or holds no spline")
}
