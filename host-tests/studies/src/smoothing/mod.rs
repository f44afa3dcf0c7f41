//! Smoothing of B-spline tool paths: figures, the thesis's trajectory generator and its cases.

pub mod cases;
pub mod comparison;
pub mod correlation;
mod figures;
mod literal;
pub mod printed;
mod records;
mod tables;
mod trajectory;

pub use figures::{Figures, measure, profile};
pub use records::{Record, records};
pub use tables::tables;
pub use trajectory::{Moment, Motion, Place, Reading, run};

use anyhow::Result;
use splineway_simulator::spline::{Path, ROOM};
use splineway_splines::{Spline, bounded, thesis};
use std::time::{Duration, Instant};

const SIZE: usize = ROOM + 3;
const PLACES: usize = SIZE * bounded::SPAN_CHECKS;

/// Which way to smooth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// Chapter 3 of Naseath 2007, as printed.
    Thesis,
    /// A set number of sweeps, inside the tube by a bound.
    Bounded,
}

/// How to smooth.
#[derive(Clone, Copy, Debug)]
pub struct Request {
    /// Way.
    pub method: Method,
    /// Radius of the tube, mm.
    pub radius: f64,
    /// Places per knot interval at which the thesis's method takes distances.
    pub precision: u32,
    /// Share of the radius within which the thesis's method ends.
    pub accuracy: f64,
    /// Most iterations of the thesis's method, sweeps of the bounded one.
    pub iterations: Option<u32>,
    /// Whether the bounded method leaves the end points where they are.
    pub ends_stay: bool,
}

impl Request {
    /// With the thesis's precision and accuracy (section 4.2), and its freedom at the ends.
    pub fn new(method: Method, radius: f64) -> Self {
        let (precision, accuracy) = (5, 0.01);
        Self { method, radius, precision, accuracy, iterations: None, ends_stay: false }
    }
}

/// A smoothed path.
#[derive(Clone, Debug)]
pub struct Smoothed {
    /// The path.
    pub path: Path,
    /// Iterations or sweeps.
    pub iterations: u32,
    /// How it ended.
    pub ending: String,
    /// Time it took.
    pub took: Duration,
}

/// Smooths a path.
///
/// # Errors
/// A radius, precision or accuracy out of its range.
pub fn smooth(given: &Path, request: &Request) -> Result<Smoothed> {
    let mut path = given.clone();
    match request.method {
        Method::Thesis => {
            let mut options = thesis::Options::new(request.radius);
            options.precision = request.precision;
            options.accuracy = request.accuracy;
            if let Some(most) = request.iterations {
                options.most_iterations = most;
            }
            let start = Instant::now();
            let outcome = thesis::smooth(&mut path, &options)?;
            let took = start.elapsed();
            let ending = match outcome.ending {
                thesis::Ending::Touching => "touches the tube",
                thesis::Ending::Straight => "is straight",
                thesis::Ending::Iterations => "iterations used up",
            };
            Ok(Smoothed { path, iterations: outcome.iterations, ending: ending.to_owned(), took })
        }
        Method::Bounded => {
            let mut options = bounded::Options::new(request.radius);
            options.ends_stay = request.ends_stay;
            if let Some(sweeps) = request.iterations {
                options.sweeps = u16::try_from(sweeps)?;
            }
            let is_flat = given.controls().iter().all(|point| point[2] == 0.0);
            let took = if is_flat {
                smooth_in::<2>(&mut path, &options)?
            } else {
                smooth_in::<3>(&mut path, &options)?
            };
            let iterations = u32::from(options.sweeps) * u32::from(options.passes);
            Ok(Smoothed { path, iterations, ending: "sweeps done".to_owned(), took })
        }
    }
}

/// Smooths a path of so many axes in bounded sweeps; returns the time that takes.
fn smooth_in<const N: usize>(path: &mut Path, options: &bounded::Options<f64>) -> Result<Duration> {
    let points: Vec<[f64; N]> =
        path.controls().iter().map(|point| std::array::from_fn(|i| point[i])).collect();
    let knots: Vec<f64> = path.printed_knots().collect();
    let mut spline = if path.is_closed() {
        Spline::<f64, N, ROOM>::closed(&points, &knots)?
    } else {
        Spline::<f64, N, ROOM>::open(&points, &knots)?
    };
    let mut room: Box<bounded::Smoother<f64, N, SIZE, PLACES>> = Box::default();
    let start = Instant::now();
    room.smooth(&mut spline, options)?;
    let took = start.elapsed();
    for (point, smoothed) in path.controls_mut().iter_mut().zip(spline.controls()) {
        point[..N].copy_from_slice(smoothed);
    }
    Ok(took)
}
