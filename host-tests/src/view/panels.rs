//! Panels of points or lines, two in a row.

use plotters::coord::Shift;
use plotters::prelude::*;
use std::ops::Range;

const WIDTH: u32 = 1400;
const HEIGHT: u32 = 520;
const COLOURS: [RGBColor; 5] = [
    RGBColor(0, 92, 171),
    RGBColor(200, 40, 40),
    RGBColor(0, 130, 80),
    RGBColor(150, 60, 160),
    RGBColor(120, 90, 40),
];

/// A series of points with its name.
pub type Series = (String, Vec<(f64, f64)>);

/// How the points of a series are shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// Each by itself.
    Points,
    /// Each, joined by lines.
    Joined,
    /// As a curve.
    Curve,
    /// As a curve in the plane: both axes have one scale.
    Path,
}

/// A panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// What is to the right, and what is up.
    pub axes: [&'static str; 2],
    /// Whether what is to the right is shown by its logarithm.
    pub logarithmic: bool,
    /// How the points of a series are shown.
    pub drawn: Drawn,
    /// Points.
    pub series: Vec<Series>,
}

impl Panel {
    /// Curves over time, s; `title` says what they are, with its unit.
    pub fn over_time(title: &'static str, series: Vec<Series>) -> Self {
        let axes = ["time, s", title];
        Self { title: title.to_owned(), axes, logarithmic: false, drawn: Drawn::Curve, series }
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Outcome = Result<(), Box<dyn std::error::Error>>;

pub fn draw(text: &mut String, title: &str, panels: &[Panel]) -> Outcome {
    let rows = panels.len().div_ceil(2).max(1);
    let size = (WIDTH, HEIGHT * rows as u32);
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(title, ("sans-serif", 26))?;
    for (area, panel) in root.split_evenly((rows, 2)).iter().zip(panels) {
        draw_panel(area, panel)?;
    }
    root.present()?;
    Ok(())
}

/// From the least to the greatest, with some room.
fn extent(values: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let room = ((high - low) * 0.05).max(1e-9);
    low - room..high + room
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Outcome {
    let right = |x: f64| if panel.logarithmic { x.log10() } else { x };
    let all = || panel.series.iter().flat_map(|(_, points)| points);
    let (mut x, mut y) = (extent(all().map(|p| right(p.0))), extent(all().map(|p| p.1)));
    if panel.drawn == Drawn::Path {
        let (width, height) = area.dim_in_pixel();
        let sides = [(&mut x, width), (&mut y, height)];
        let per = |range: &Range<f64>, pixels: u32| (range.end - range.start) / f64::from(pixels);
        let scale = sides.iter().map(|(range, pixels)| per(range, *pixels)).fold(0.0, f64::max);
        for (range, pixels) in sides {
            let middle = f64::midpoint(range.start, range.end);
            let half = scale * f64::from(pixels) / 2.0;
            *range = middle - half..middle + half;
        }
    }
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&panel.title, ("sans-serif", 18))
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(x, y)?;
    let label = |x: &f64| {
        if panel.logarithmic { format!("{:.2}", 10f64.powf(*x)) } else { format!("{x:.4}") }
    };
    let label = |x: &f64| {
        let text = label(x);
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    };
    chart
        .configure_mesh()
        .x_desc(panel.axes[0])
        .y_desc(panel.axes[1])
        .x_label_formatter(&label)
        .light_line_style(WHITE)
        .draw()?;
    for ((name, points), colour) in panel.series.iter().zip(COLOURS.into_iter().cycle()) {
        let points: Vec<(f64, f64)> = points.iter().map(|p| (right(p.0), p.1)).collect();
        if matches!(panel.drawn, Drawn::Curve | Drawn::Path) {
            chart
                .draw_series(LineSeries::new(points.iter().copied(), colour))?
                .label(name)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
            continue;
        }
        if panel.drawn == Drawn::Joined {
            chart.draw_series(LineSeries::new(points.iter().copied(), colour))?;
        }
        chart
            .draw_series(points.iter().map(|p| Circle::new(*p, 4, colour.filled())))?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour.filled()));
    }
    let corner = if panel.drawn == Drawn::Joined {
        SeriesLabelPosition::UpperLeft
    } else {
        SeriesLabelPosition::MiddleRight
    };
    chart
        .configure_series_labels()
        .position(corner)
        .border_style(BLACK.mix(0.4))
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
