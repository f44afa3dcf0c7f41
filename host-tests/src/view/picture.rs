//! Plots as SVG and PNG.

use super::{Curve, Scene};
use anyhow::{Result, anyhow};
use plotters::coord::Shift;
use plotters::prelude::*;
use splineway_simulator::record::Point;

const SIZE: (u32, u32) = (1400, 1500);
const SPEEDS_SIZE: (u32, u32) = (1400, 1100);
const COLOURS: [RGBColor; 9] = [
    RGBColor(0, 92, 171),
    RGBColor(214, 96, 0),
    RGBColor(0, 130, 80),
    RGBColor(150, 60, 160),
    RGBColor(120, 90, 40),
    RGBColor(0, 140, 150),
    RGBColor(200, 40, 80),
    RGBColor(90, 90, 90),
    RGBColor(120, 140, 0),
];
const GREY: RGBColor = RGBColor(170, 170, 170);
const BAND: RGBColor = RGBColor(255, 214, 150);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The plot as SVG text.
pub fn svg(scene: &Scene<'_>) -> Result<String> {
    let mut text = String::new();
    draw(&mut text, scene).map_err(|error| anyhow!("plot: {error}"))?;
    Ok(text)
}

/// A picture as PNG; letters need a font on the machine.
pub fn png(svg: &str) -> Result<Vec<u8>> {
    use resvg::{tiny_skia, usvg};
    let mut options = usvg::Options::default();
    options.fontdb_mut().load_system_fonts();
    let tree = usvg::Tree::from_str(svg, &options)?;
    let size = tree.size().to_int_size();
    let mut pixels = tiny_skia::Pixmap::new(size.width(), size.height())
        .ok_or_else(|| anyhow!("no picture of this size"))?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
    Ok(pixels.encode_png()?)
}

/// Speeds over the way, one curve per name, as SVG text.
pub fn speeds_svg(title: &str, curves: &[Curve]) -> Result<String> {
    let mut text = String::new();
    draw_speeds(&mut text, title, curves).map_err(|error| anyhow!("plot: {error}"))?;
    Ok(text)
}

fn draw_speeds(
    text: &mut String,
    title: &str,
    curves: &[Curve],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(text, SPEEDS_SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(title, ("sans-serif", 26))?;
    let panels = root.split_evenly((curves.len().max(1), 1));
    let (_, end) = range(curves.iter().flat_map(|curve| &curve.points).map(|point| point.0));
    let (_, most) = range(curves.iter().flat_map(|curve| &curve.points).map(|point| point.1));
    for (n, (panel, curve)) in panels.iter().zip(curves).enumerate() {
        let mut chart = ChartBuilder::on(panel)
            .margin(8)
            .caption(&curve.name, ("sans-serif", 18))
            .x_label_area_size(36)
            .y_label_area_size(70)
            .build_cartesian_2d(0.0..end.max(1e-3), 0.0..most.max(1e-3) * 1.05)?;
        chart
            .configure_mesh()
            .x_desc("way, mm")
            .y_desc("speed, mm/s")
            .light_line_style(WHITE)
            .draw()?;
        let colour = COLOURS[n % COLOURS.len()];
        chart.draw_series(LineSeries::new(curve.points.iter().copied(), colour))?;
    }
    root.present()?;
    Ok(())
}

fn draw(text: &mut String, scene: &Scene<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(scene.title, ("sans-serif", 26))?;
    let (path, rest) = root.split_vertically(720);
    draw_path(&path, scene)?;
    let panels = rest.split_evenly((3, 1));
    let limits = scene.limits;
    let per_axis = |value: fn(&Point) -> &Vec<f64>| {
        (0..limits.len())
            .map(|axis| scene.trace.points.iter().map(|p| (p.time, value(p)[axis])).collect())
            .collect::<Vec<Vec<(f64, f64)>>>()
    };
    let speed = vec![scene.trace.points.iter().map(|p| (p.time, p.speed)).collect()];
    draw_panel(&panels[0], "path speed, mm/s", &speed, &[], &[])?;
    let bounds: Vec<f64> = limits.iter().map(|axis| axis.acceleration).collect();
    draw_panel(
        &panels[1],
        "acceleration, mm/s2",
        &per_axis(|p| &p.acceleration),
        &bounds,
        scene.letters,
    )?;
    let bounds: Vec<f64> = limits.iter().map(|axis| axis.jerk).collect();
    draw_panel(&panels[2], "jerk, mm/s3", &per_axis(|p| &p.jerk), &bounds, scene.letters)?;
    root.present()?;
    Ok(())
}

/// The two axes in which the path extends furthest.
fn view_axes(scene: &Scene<'_>) -> (usize, usize) {
    let extent = |axis: usize| {
        let (low, high) = range((0..scene.track.len()).map(|k| scene.track.point(k)[axis]));
        high - low
    };
    let mut axes: Vec<usize> = (0..scene.track.axes.min(3)).collect();
    axes.sort_by(|&a, &b| extent(b).total_cmp(&extent(a)));
    (axes[0].min(axes[1]), axes[0].max(axes[1]))
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

fn draw_path(area: &Area<'_>, scene: &Scene<'_>) -> Result<(), Box<dyn std::error::Error>> {
    let (p, q) = view_axes(scene);
    let programmed: Vec<(f64, f64)> = (0..scene.track.len())
        .map(|k| (scene.track.point(k)[p], scene.track.point(k)[q]))
        .collect();
    let (x0, x1) = range(programmed.iter().map(|point| point.0));
    let (y0, y1) = range(programmed.iter().map(|point| point.1));
    // Equal scales on both axes.
    let (width, height) = area.dim_in_pixel();
    let (width, height) = (f64::from(width) - 110.0, f64::from(height) - 90.0);
    let scale = ((x1 - x0).max(1e-3) * 1.06 / width).max((y1 - y0).max(1e-3) * 1.06 / height);
    let (cx, cy) = (f64::midpoint(x0, x1), f64::midpoint(y0, y1));
    let (w, h) = (scale * width / 2.0, scale * height / 2.0);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(40)
        .y_label_area_size(70)
        .build_cartesian_2d(cx - w..cx + w, cy - h..cy + h)?;
    chart
        .configure_mesh()
        .x_desc(format!("{}, mm", scene.letters[p]))
        .y_desc(format!("{}, mm", scene.letters[q]))
        .light_line_style(WHITE)
        .draw()?;
    let band = (2.0 * scene.tolerance / scale).clamp(1.0, 60.0);
    chart
        .draw_series(LineSeries::new(programmed.clone(), BAND.stroke_width(band.round() as u32)))?;
    chart.draw_series(LineSeries::new(programmed, GREY))?;
    let run = scene.trace.points.iter().map(|point| (point.position[p], point.position[q]));
    chart.draw_series(LineSeries::new(run, COLOURS[0]))?;
    Ok(())
}

fn draw_panel(
    area: &Area<'_>,
    name: &str,
    series: &[Vec<(f64, f64)>],
    bounds: &[f64],
    letters: &[char],
) -> Result<(), Box<dyn std::error::Error>> {
    let (_, end) = range(series.iter().flatten().map(|point| point.0));
    let (low, high) = range(series.iter().flatten().map(|point| point.1));
    let most = bounds.iter().copied().fold(0.0, f64::max);
    let (low, high) = (low.min(-most) * 1.08, high.max(most).max(1e-9) * 1.08);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(36)
        .y_label_area_size(70)
        .build_cartesian_2d(0.0..end.max(1e-3), low..high)?;
    chart.configure_mesh().x_desc("time, s").y_desc(name).light_line_style(WHITE).draw()?;
    for bound in bounds {
        for sign in [-1.0, 1.0] {
            let line = [(0.0, sign * bound), (end, sign * bound)];
            chart.draw_series(LineSeries::new(line, RED.mix(0.5)))?;
        }
    }
    for (n, points) in series.iter().enumerate() {
        let colour = COLOURS[n];
        let drawn = chart.draw_series(LineSeries::new(points.iter().copied(), colour))?;
        if let Some(letter) = letters.get(n) {
            drawn
                .label(letter.to_string())
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour));
        }
    }
    if !letters.is_empty() {
        chart
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(GREY)
            .draw()?;
    }
    Ok(())
}
