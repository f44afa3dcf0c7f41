//! What smoothing a spline takes on the target.

use super::Free;
use super::built::{Image, values};
use anyhow::{Context, Result, ensure};
use splineway_emulator::smoothing::{Smoothed, smooth};
use splineway_simulator::spline::Path;
use splineway_splines::bounded;
use splineway_studies::smoothing::cases::all;

/// Radius of the tube, mm.
const RADIUS: f64 = 0.125;

/// The spline as the image reads it.
fn bytes(path: &Path, sweeps: u16) -> Vec<u8> {
    let controls = path.controls();
    let head = [f64::from(sweeps), controls.len() as f64, RADIUS];
    let points = controls.iter().flat_map(|point| [point[0], point[1]]);
    let numbers = head.into_iter().chain(path.knots().iter().copied()).chain(points);
    numbers.flat_map(|x| (x as f32).to_le_bytes()).collect()
}

/// Smooths on host and target; gives what came out, and instructions on the target.
fn run(image: &Image, path: &Path, sweeps: u16) -> Result<(Smoothed, u64)> {
    let bytes = bytes(path, sweeps);
    let mut source = bytes.iter().copied();
    let host = smooth(&mut || source.next(), &mut Free).context("no spline")?;
    let file = std::env::temp_dir().join(format!("splineway-{}.spline", std::process::id()));
    std::fs::write(&file, &bytes)?;
    let said = image.emulate(&[file.to_str().context("the name of a file")?.to_owned()]);
    std::fs::remove_file(&file)?;
    let said = said?;
    let values = values(&said);
    let get = |name: &str| values.get(name).copied().with_context(|| format!("no {name}: {said}"));
    ensure!(
        get("digest")? == u64::from(host.digest),
        "the target's control points are not the host's"
    );
    Ok((host, get("instructions")?))
}

/// Prints what the thesis's method and the bounded one take on the cases of Naseath 2007.
pub fn report() -> Result<()> {
    let image = Image::build_of("emulator", "smoothing")?;
    let sweeps = bounded::Options::<f32>::new(0.0).sweeps;
    println!(
        "smoothing of plane splines, R = {RADIUS} mm, f32, instructions; control points are the host's"
    );
    println!(
        "{:<12} {:>6} | {:>28} | {:>28} | {:>10}",
        "case", "points", "thesis: all, per iteration", "bounded: all, per point", "per sweep"
    );
    for case in all()? {
        let (printed, whole) = run(&image, &case.path, 0)?;
        let (_, bounded) = run(&image, &case.path, sweeps)?;
        let (_, more) = run(&image, &case.path, 2 * sweeps)?;
        let points = f64::from(printed.points);
        // Two passes of sweeps, and one after the thesis's moves.
        let swept = 3.0 * f64::from(sweeps) * points;
        println!(
            "{:<12} {:>6} | {whole:>14} {:>13.0} | {bounded:>14} {:>13.0} | {:>10.0}",
            format!("{}: {}", case.number, case.name),
            printed.points,
            whole as f64 / f64::from(printed.iterations.max(1)) / points,
            bounded as f64 / points,
            (more as f64 - bounded as f64) / swept,
        );
    }
    println!("per iteration, point and sweep: of one control point");
    Ok(())
}
