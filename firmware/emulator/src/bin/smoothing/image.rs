//! The image: the file with the spline, the text that comes out.

use crate::timer::{Timer, instructions};
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
use panic_semihosting as _;
use splineway_emulator::smoothing::{Smoothed, smooth};
use splineway_semihosting::File;

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
    if go().is_none() {
        hprintln!("the file cannot be read, or holds no spline");
        debug::exit(debug::EXIT_FAILURE);
    }
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::nop();
    }
}
