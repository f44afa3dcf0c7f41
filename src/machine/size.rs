//! The size of a core where its type names none.

/// Blocks of the look-ahead: enough for short lines, of which runs are kept as splines. 32 and more help with long
/// corners in a row.
pub const BLOCKS: usize = 16;

/// Nodes of the planning window: from 200 mm/s to a stop at 2,000 mm/s2 and cells of a millimetre.
pub const NODES: usize = 64;
