//! G-code.
use super::Program;
/// x
pub fn parse(_t:&str,_f:f64)->anyhow::Result<Program>{ anyhow::bail!("todo") }
