//! The path of a run, as its setpoints trace it.

use crate::reference::Place;
use anyhow::Result;
use splineway_simulator::run::{Observer, Sample};

/// Records tangent and curvature by arc length at every servo cycle, and the speeds.
#[derive(Clone, Debug)]
pub struct Geometry {
    /// The places.
    pub places: Vec<Place>,
    /// Speed at each, mm/s.
    pub speeds: Vec<f64>,
    cycle: f64,
    acceleration: f64,
}

impl Geometry {
    /// An empty record of a run with this servo cycle, s.
    pub fn new(cycle: f64) -> Self {
        Self { places: Vec::new(), speeds: Vec::new(), cycle, acceleration: 0.0 }
    }
}

impl Observer for Geometry {
    fn setpoint(&mut self, sample: &Sample<'_>) -> Result<()> {
        let square: f64 = sample.velocity.iter().map(|v| v * v).sum();
        let speed = square.sqrt();
        let tangent: Vec<f64> = sample.velocity.iter().map(|v| v / speed.max(1e-9)).collect();
        let along: f64 = tangent.iter().zip(sample.acceleration).map(|(t, a)| t * a).sum();
        let bend = sample
            .acceleration
            .iter()
            .zip(&tangent)
            .map(|(a, t)| (a - t * along) / square.max(1e-9))
            .collect();
        if let (Some(last), Some(before)) = (self.places.last_mut(), self.speeds.last()) {
            // Exact for a quartic in time.
            let h = self.cycle;
            last.step = (before + speed) * h / 2.0 + (self.acceleration - along) * h * h / 12.0;
        }
        self.places.push(Place { step: 0.0, tangent, bend });
        self.speeds.push(speed);
        self.acceleration = along;
        Ok(())
    }
}
