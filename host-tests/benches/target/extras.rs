//! What outputs, input shaping and motors that follow several axes add to a tick on the target.

use super::built::{Image, values};
use anyhow::{Context, Result};

/// Parts: what the image calls them, what they are, and the goal of a call at worst, instructions.
const PARTS: [(&str, &str, u64); 8] = [
    ("tick", "Interpolator::tick, with outputs", 600),
    ("switch_idle", "Interpolator::switch at rest", 100),
    ("switch", "Interpolator::switch, 8 outputs and power in proportion to speed", 2500),
    ("zv", "Shaper::shape, ZV", 1500),
    ("mzv", "Shaper::shape, MZV", 2000),
    ("ei", "Shaper::shape, EI", 2000),
    ("smooth", "Shaper::shape, smooth, 40 Hz at 1 kHz", 12_000),
    ("motors", "Linear::setpoint, CoreXY and Z", 600),
];

/// Prints the table; gives goals that were missed.
pub fn report() -> Result<Vec<String>> {
    let image = Image::build_with("emulator", "extras", "extras")?;
    let said = image.emulate(&[])?;
    let values = values(&said);
    let get = |name: &str| values.get(name).copied().with_context(|| format!("no {name}: {said}"));
    println!("what may be added to a tick (f32, 3 axes), instructions: mean, worst");
    let mut missed = Vec::new();
    for (name, what, goal) in PARTS {
        let worst = get(&format!("{name}_worst"))?;
        println!("{what:<68} {:>6} {worst:>6}", get(name)?);
        if worst > goal {
            missed.push(format!("{what} took {worst} instructions; {goal} is the goal"));
        }
    }
    Ok(missed)
}
