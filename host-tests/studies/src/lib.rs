//! Studies: what the core is compared with, and the figures of its documents.
//!
//! [`anymotion`]: the least time of any motion inside the band. [`baseline`]: other controllers' speed laws. [`mod@reference`]: the least time along a fixed path, by another method;
//! [`geometry`] records such a path. [`stop`]: the
//! shortest stop on a path that was run. [`corners`]: the corner transitions of the literature. [`smoothing`]: the
//! cases of Naseath (2007). [`paper`]: the routines and paths of Guo, Yan, Wang (2023). [`figures`]: times, deviations and
//! costs of paths, judged. [`others`]: planners of others, from their papers. [`paths`]: tool paths to measure.
//! [`reshaping`]: a planned motion improved window by window, shape and speed together.
//!
//! What does not belong here: anything that a simulation needs (`splineway-simulator`), and how figures are shown
//! (`splineway-host`).

pub mod anymotion;
pub mod baseline;
pub mod corners;
pub mod figures;
pub mod geometry;
pub mod others;
pub mod paper;
pub mod paths;
pub mod reference;
pub mod reshaping;
mod rows;
pub mod smoothing;
pub mod stop;
