//! The size of a core where its type names none.

/// Blocks of the look-ahead: enough for short lines, of which runs are kept as splines. 32 and more help with long
/// corners in a row.
pub const BLOCKS: usize = 16;

/// Nodes of the planning window: from 200 mm/s to a stop at 2,000 mm/s2 and cells of a millimetre.
pub const NODES: usize = 64;

/// Digital outputs that switch with the path (feature `outputs`).
#[cfg(feature = "outputs")]
pub const DIGITAL: usize = 8;

/// Analogue outputs that do.
#[cfg(feature = "outputs")]
pub const ANALOGUE: usize = 4;

/// Switches of one output that wait (feature `outputs`): a power of two.
#[cfg(feature = "outputs")]
pub const SWITCHES: usize = 16;

/// Changes of power that wait: a power of two.
#[cfg(feature = "outputs")]
pub const POWERS: usize = 64;
