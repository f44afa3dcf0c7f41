//! A smoothed path in its tube, curvature along it and feed over time, as in figures 4-8 to 4-27 of Naseath 2007.

use plotters::coord::Shift;
use plotters::prelude::*;
use splineway_simulator::spline::Path;
use splineway_splines::Trajectory;
use splineway_studies::smoothing::{Place, Reading, profile, run};

const SIZE: (u32, u32) = (1400, 1700);
const GIVEN: RGBColor = RGBColor(0, 92, 171);
const SMOOTH: [RGBColor; 3] = [RGBColor(200, 40, 40), RGBColor(0, 130, 80), RGBColor(150, 60, 160)];
const TUBE: RGBColor = RGBColor(120, 120, 120);
/// Share of the path's extent that the close-up shows at least.
const CLOSE: f64 = 0.06;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Outcome = Result<(), Box<dyn std::error::Error>>;

/// What the plot shows.
#[derive(Clone, Copy, Debug)]
pub struct TubeScene<'a> {
    /// Title.
    pub title: &'a str,
    /// Path as given.
    pub given: &'a Path,
    /// Paths smoothed, with their names; the last one is shown in the tube.
    pub smooth: &'a [(String, &'a Path)],
    /// Radius of the tube, mm.
    pub radius: f64,
    /// The generator whose feed is shown.
    pub trajectory: &'a Trajectory<f64>,
    /// How it is read.
    pub reading: Reading,
}

pub fn draw(text: &mut String, scene: &TubeScene<'_>) -> Outcome {
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(scene.title, ("sans-serif", 26))?;
    let (paths, rest) = root.split_vertically(800);
    let (whole, close) = paths.split_horizontally(700);
    let given = profile(scene.given);
    let smoothed: Vec<Vec<Place>> = scene.smooth.iter().map(|(_, path)| profile(path)).collect();
    let smooth = smoothed.last().unwrap_or(&given);
    let edges = [-scene.radius, scene.radius].map(|radius| edge(scene.given, radius));
    // The close-up is where the path as given is bent most.
    let worst = given.iter().max_by(|a, b| a.curvature.total_cmp(&b.curvature));
    let (low, high) = extent(given.iter().chain(smooth));
    let size = (high[0] - low[0]).max(high[1] - low[1]).max(scene.radius);
    let centre = [f64::midpoint(low[0], high[0]), f64::midpoint(low[1], high[1])];
    let views = [
        (whole, "path in its tube", centre, size * 0.53),
        (
            close,
            "where it was bent most",
            worst.map_or(centre, |place| [place.point[0], place.point[1]]),
            (size * CLOSE).max(scene.radius * 6.0),
        ),
    ];
    for (area, caption, middle, reach) in views {
        draw_path(&area, caption, middle, reach, &edges, [&given, smooth])?;
    }
    let (curvature, feed) = rest.split_vertically(430);
    let all = || std::iter::once(&given).chain(&smoothed);
    let names = std::iter::once("given").chain(scene.smooth.iter().map(|(name, _)| name.as_str()));
    let named = |points: Vec<Vec<(f64, f64)>>| -> Vec<(String, Vec<(f64, f64)>)> {
        names.clone().map(str::to_owned).zip(points).collect()
    };
    let curvatures =
        all().map(|places| places.iter().map(|place| (place.way, place.curvature)).collect());
    draw_curves(&curvature, "way, mm", "curvature, 1/mm", &named(curvatures.collect()))?;
    let feeds = all().map(|places| {
        let motion = run(scene.trajectory, places, scene.reading);
        motion.moments.iter().map(|moment| (moment.time, moment.speed)).collect()
    });
    draw_curves(&feed, "time, s", "feed by section 4.5, mm/s", &named(feeds.collect()))?;
    root.present()?;
    Ok(())
}

/// One side of the tube.
fn edge(path: &Path, radius: f64) -> Vec<(f64, f64)> {
    const PARTS: u32 = 60;
    (0..path.spans())
        .flat_map(|span| (0..=PARTS).map(move |k| (span, f64::from(k) / f64::from(PARTS))))
        .map(|(span, u)| path.offset(span, u, radius))
        .map(|p| (p[0], p[1]))
        .collect()
}

fn extent<'a>(places: impl Iterator<Item = &'a Place>) -> ([f64; 2], [f64; 2]) {
    let mut range = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for place in places {
        for i in 0..2 {
            range.0[i] = range.0[i].min(place.point[i]);
            range.1[i] = range.1[i].max(place.point[i]);
        }
    }
    range
}

fn draw_path(
    area: &Area<'_>,
    caption: &str,
    middle: [f64; 2],
    reach: f64,
    edges: &[Vec<(f64, f64)>; 2],
    paths: [&Vec<Place>; 2],
) -> Outcome {
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .caption(caption, ("sans-serif", 18))
        .x_label_area_size(36)
        .y_label_area_size(64)
        .build_cartesian_2d(
            middle[0] - reach..middle[0] + reach,
            middle[1] - reach..middle[1] + reach,
        )?;
    chart.configure_mesh().x_desc("X, mm").y_desc("Y, mm").light_line_style(WHITE).draw()?;
    // What lies outside would be drawn along the frame.
    let is_seen =
        |p: &(f64, f64)| (p.0 - middle[0]).abs() <= reach && (p.1 - middle[1]).abs() <= reach;
    for edge in edges {
        for part in edge.split(|p| !is_seen(p)) {
            chart.draw_series(LineSeries::new(part.iter().copied(), TUBE))?;
        }
    }
    for (places, colour) in paths.into_iter().zip([GIVEN, SMOOTH[0]]) {
        let line: Vec<(f64, f64)> =
            places.iter().map(|place| (place.point[0], place.point[1])).collect();
        for part in line.split(|p| !is_seen(p)) {
            chart.draw_series(LineSeries::new(part.iter().copied(), colour.stroke_width(2)))?;
        }
    }
    Ok(())
}

fn draw_curves(
    area: &Area<'_>,
    along: &str,
    name: &str,
    curves: &[(String, Vec<(f64, f64)>)],
) -> Outcome {
    let all = || curves.iter().flat_map(|(_, points)| points);
    let end = all().map(|p| p.0).fold(1e-3, f64::max);
    let most = all().map(|p| p.1).fold(1e-9, f64::max) * 1.05;
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(36)
        .y_label_area_size(80)
        .build_cartesian_2d(0.0..end, 0.0..most)?;
    chart.configure_mesh().x_desc(along).y_desc(name).light_line_style(WHITE).draw()?;
    let colours = std::iter::once(GIVEN).chain(SMOOTH.into_iter().cycle());
    for ((label, points), colour) in curves.iter().zip(colours) {
        chart
            .draw_series(LineSeries::new(points.iter().copied(), colour))?
            .label(label)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .border_style(TUBE)
        .background_style(WHITE.mix(0.8))
        .draw()?;
    Ok(())
}
