//! Plots as one self-contained page.

use super::Scene;
use super::picture::view_axes;
use anyhow::Result;
use serde_json::json;

/// The page's frame; the data is put in as JSON.
const PAGE: &str = include_str!("page.html");

/// A limit counts as binding from this share of it on, and a motion as steady below this one.
const BINDS: (f64, f64) = (0.95, 0.05);

/// What holds the motion back at a point: 3 the jerk of an axis, 2 its acceleration, 1 feed or velocity
/// (the speed is steady), 0 nothing to speak of.
fn binding(scene: &Scene<'_>, k: usize) -> u8 {
    let points = &scene.trace.points;
    let (before, point) = (&points[k.saturating_sub(1)], &points[k]);
    let gain = (point.speed - before.speed) / (point.time - before.time).max(1.0e-9);
    let most = |values: &[f64], limit: fn(&splineway_simulator::machine::Axis) -> f64| {
        let shares = values.iter().zip(scene.limits).map(|(x, axis)| x.abs() / limit(axis));
        shares.fold(0.0, f64::max)
    };
    let jerk = most(&point.jerk, |axis| axis.jerk);
    let acceleration = most(&point.acceleration, |axis| axis.acceleration);
    if jerk >= BINDS.0 {
        3
    } else if acceleration >= BINDS.0 {
        2
    } else {
        let least = scene.limits.iter().map(|axis| axis.acceleration).fold(f64::INFINITY, f64::min);
        u8::from(gain.abs() <= BINDS.1 * least && point.speed > 0.0)
    }
}

/// The plot as a page: path with its band in the plane and in space, speed, acceleration and jerk over
/// time, with zoom.
pub fn page(scene: &Scene<'_>) -> Result<String> {
    let (p, q) = view_axes(scene);
    let round = |x: f64, digits: i32| {
        let scale = 10f64.powi(digits);
        (x * scale).round() / scale
    };
    let points = &scene.trace.points;
    let column = |value: &dyn Fn(&splineway_simulator::record::Point) -> f64, digits: i32| {
        points.iter().map(|point| round(value(point), digits)).collect::<Vec<f64>>()
    };
    let axes = scene.limits.len();
    // The third axis of the view in space; a plane path has one too, which stands still.
    let third = (0..axes.min(3)).find(|&axis| axis != p && axis != q);
    let depth = |position: &dyn Fn(usize) -> f64| third.map_or(0.0, position);
    let binds: Vec<u8> = (0..points.len()).map(|k| binding(scene, k)).collect();
    let data = json!({
        "title": scene.title,
        "tolerance": scene.tolerance,
        "letters": scene.letters,
        "view": [scene.letters[p].to_string(), scene.letters[q].to_string()],
        "path": (0..scene.track.len())
            .map(|k| {
                let at = scene.track.point(k);
                [round(at[p], 6), round(at[q], 6), round(depth(&|axis| at[axis]), 6)]
            })
            .collect::<Vec<_>>(),
        "x": column(&|point| point.position[p], 6),
        "y": column(&|point| point.position[q], 6),
        "z": column(&|point| depth(&|axis| point.position[axis]), 6),
        "depth": third.map(|axis| scene.letters[axis].to_string()),
        "binds": binds,
        "time": column(&|point| point.time, 6),
        "line": points.iter().map(|point| point.line).collect::<Vec<_>>(),
        "speed": column(&|point| point.speed, 3),
        "acceleration": (0..axes).map(|axis| column(&|point| point.acceleration[axis], 1)).collect::<Vec<_>>(),
        "jerk": (0..axes).map(|axis| column(&|point| point.jerk[axis], 0)).collect::<Vec<_>>(),
        "limits": scene.limits.iter()
            .map(|axis| json!({"acceleration": axis.acceleration, "jerk": axis.jerk}))
            .collect::<Vec<_>>(),
    });
    // "</" inside a string would end the script.
    let data = serde_json::to_string(&data)?.replace("</", "<\\/");
    let title = scene.title.replace('&', "&amp;").replace('<', "&lt;");
    Ok(PAGE.replace("{{TITLE}}", &title).replace("{{DATA}}", &data))
}
