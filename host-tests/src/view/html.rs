//! Plots as one self-contained page.

use super::Scene;
use super::picture::view_axes;
use anyhow::Result;
use serde_json::json;

/// The page's frame; the data is put in as JSON.
const PAGE: &str = include_str!("page.html");

/// The plot as a page: path with its band, speed, acceleration and jerk over time, with zoom.
pub fn page(scene: &Scene<'_>) -> Result<String> {
    let (p, q) = view_axes(scene);
    let round = |x: f64, digits: i32| {
        let scale = 10f64.powi(digits);
        (x * scale).round() / scale
    };
    let points = &scene.trace.points;
    let column = |value: &dyn Fn(&super::Point) -> f64, digits: i32| {
        points.iter().map(|point| round(value(point), digits)).collect::<Vec<f64>>()
    };
    let axes = scene.limits.len();
    let data = json!({
        "title": scene.title,
        "tolerance": scene.tolerance,
        "letters": scene.letters,
        "view": [scene.letters[p].to_string(), scene.letters[q].to_string()],
        "path": (0..scene.track.len())
            .map(|k| [round(scene.track.point(k)[p], 6), round(scene.track.point(k)[q], 6)])
            .collect::<Vec<_>>(),
        "x": column(&|point| point.position[p], 6),
        "y": column(&|point| point.position[q], 6),
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
