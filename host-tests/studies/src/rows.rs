//! Rows of a linear or quadratic program, collected one by one.

use anyhow::{Result, ensure};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
};

/// Rows `coefficients . x <= bound`, each scaled.
#[derive(Default)]
pub struct Rows {
    row: Vec<usize>,
    column: Vec<usize>,
    value: Vec<f64>,
    bound: Vec<f64>,
}

impl Rows {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.bound.len()
    }

    /// A row, scaled to a bound of 1.
    pub fn push(&mut self, entries: impl IntoIterator<Item = (usize, f64)>, bound: f64) {
        self.push_scaled(entries, bound, bound.abs());
    }

    /// A row, divided by `scale`.
    pub fn push_scaled(
        &mut self,
        entries: impl IntoIterator<Item = (usize, f64)>,
        bound: f64,
        scale: f64,
    ) {
        for (column, value) in entries {
            self.row.push(self.bound.len());
            self.column.push(column);
            self.value.push(value / scale);
        }
        self.bound.push(bound / scale);
    }

    /// -bound <= coefficients . x <= bound.
    pub fn both(&mut self, entries: &[(usize, f64)], bound: f64) {
        self.push(entries.iter().copied(), bound);
        self.push(entries.iter().map(|&(k, x)| (k, -x)), bound);
    }

    /// The least x . objective x / 2 + linear . x.
    ///
    /// # Errors
    /// The solver does not come to an end.
    pub fn minimise(
        self,
        objective: &CscMatrix<f64>,
        linear: &[f64],
        cones: &[SupportedConeT<f64>],
    ) -> Result<Vec<f64>> {
        let rows = self.len();
        let constraint =
            CscMatrix::new_from_triplets(rows, linear.len(), self.row, self.column, self.value);
        let settings = DefaultSettingsBuilder::default().verbose(false).max_iter(100).build()?;
        let mut solver =
            DefaultSolver::new(objective, linear, &constraint, &self.bound, cones, settings)?;
        solver.solve();
        let status = solver.solution.status;
        ensure!(
            matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved),
            "the program of {rows} rows was not solved: {status:?}"
        );
        Ok(solver.solution.x)
    }
}
