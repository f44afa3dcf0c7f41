//! The host side of splineway: reading tool paths, simulating servo cycles, judging and showing.

pub mod baseline;
pub mod commands;
pub mod corners;
pub mod figures;
pub mod lint;
pub mod machine;
pub mod program;
pub mod reference;
pub mod run;
pub mod smoothing;
pub mod stream;
pub mod trial;
pub mod view;
