//! Panels of points or lines, two in a row.

use plotters::coord::Shift;
use plotters::prelude::*;

const WIDTH: u32 = 1400;
const HEIGHT: u32 = 520;
const COLOURS: [RGBColor; 3] = [RGBColor(0, 92, 171), RGBColor(200, 40, 40), RGBColor(0, 130, 80)];

/// A series of points with its name.
pub type Series = (String, Vec<(f64, f64)>);

/// A panel.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Title.
    pub title: String,
    /// What is to the right, and what is up.
    pub axes: [&'static str; 2],
    /// Whether what is to the right is shown by its logarithm.
    pub logarithmic: bool,
    /// Whether the points of a series are joined.
    pub joined: bool,
    /// Points.
    pub series: Vec<Series>,
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
fn extent(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) =
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let room = ((high - low) * 0.05).max(1e-9);
    low - room..high + room
}

fn draw_panel(area: &Area<'_>, panel: &Panel) -> Outcome {
    let right = |x: f64| if panel.logarithmic { x.log10() } else { x };
    let all = || panel.series.iter().flat_map(|(_, points)| points);
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&panel.title, ("sans-serif", 18))
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(extent(all().map(|p| right(p.0))), extent(all().map(|p| p.1)))?;
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
        if panel.joined {
            chart.draw_series(LineSeries::new(points.iter().copied(), colour))?;
        }
        chart
            .draw_series(points.iter().map(|p| Circle::new(*p, 4, colour.filled())))?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 9, y), 4, colour.filled()));
    }
    let corner = if panel.joined {
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
