//! G-code as milling controllers and slicers write it.
//!
//! Words: G0-G3, G4 P, G9, G17-G19, G20/G21, G28, G40, G49, G53, G54, G61/G61.1/G64 P Q, G80,
//! G90/G91, G90.1/G91.1, G92/G92.1, G93/G94, axes X Y Z A B C U V W, I J K R P, F, N, comments,
//! block delete, M2/M30. What has no bearing on the path (spindle, coolant, tools, extruder) is
//! skipped; what might have, and is not known, is skipped with one warning.

mod interpreter;
mod words;

pub use interpreter::{parse, parse_with};
