//! Guo, Yan, Wang 2023: the routines as printed ([`routines`]), the paths of their section 4 ([`cases`]), and what the core
//! makes of those in its paper mode and in its own ([`measure`]), beside the figures that are printed ([`printed`]).

pub mod cases;
pub mod measure;
pub mod printed;
pub mod routines;
