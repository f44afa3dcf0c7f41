//! Greatest stack of a function with all it calls, from a disassembly.

use super::listing::{Instruction, Listing};
use anyhow::{Result, ensure};
use std::collections::BTreeSet;

/// What a function does to the stack.
#[derive(Default)]
struct Use {
    frame: u32,
    calls: BTreeSet<u32>,
    /// It calls by pointer, or moves the stack pointer by a register.
    opaque: bool,
}

/// Bytes of a register list.
fn registers(list: &str) -> Option<u32> {
    let inner = list.split_once('{')?.1.split_once('}')?.0;
    let mut count = 0;
    for part in inner.split(',').map(str::trim) {
        count += match part.split_once('-') {
            Some((first, last)) => {
                let number = |name: &str| name.get(1..)?.parse::<u32>().ok();
                number(last)? - number(first)? + 1
            }
            None => 1,
        };
    }
    Some(count * if inner.trim_start().starts_with('d') { 8 } else { 4 })
}

fn immediate(text: &str) -> Option<u32> {
    let digits = text.split_once('#')?.1;
    let digits = digits.trim_start_matches('-');
    let end = digits.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(digits.len());
    digits[..end].parse().ok()
}

impl Use {
    fn add(&mut self, line: &Instruction) {
        let (mnemonic, operands) = (line.mnemonic.as_str(), line.operands.as_str());
        let pushes = mnemonic.starts_with("push")
            || mnemonic.starts_with("vpush")
            || (mnemonic.starts_with("stmdb") && operands.starts_with("sp!"));
        if pushes {
            self.frame += registers(operands).unwrap_or(0);
        } else if mnemonic.starts_with("sub") && operands.starts_with("sp,") {
            match immediate(operands) {
                Some(bytes) => self.frame += bytes,
                None => self.opaque = true,
            }
        } else if mnemonic.starts_with("str") && operands.contains("[sp, #-") {
            self.frame += operands.split("[sp, ").nth(1).and_then(immediate).unwrap_or(0);
        } else if mnemonic.starts_with("blx") && !operands.contains('<') {
            self.opaque = true;
        }
        // A branch to the beginning of a function is a call, or one in the tail.
        let branches = mnemonic.starts_with('b') && !mnemonic.starts_with("bic");
        let compares = mnemonic.starts_with("cb");
        if (branches || compares)
            && !operands.contains("+0x")
            && let Some(address) = line.target()
        {
            self.calls.insert(address);
        }
    }
}

/// Most bytes that the function with this name needs, with all it calls.
pub fn worst(listing: &Listing, entry: &str) -> Result<u32> {
    depth(listing, listing.find(entry)?, &mut Vec::new())
}

fn depth(listing: &Listing, address: u32, above: &mut Vec<u32>) -> Result<u32> {
    let Some(function) = listing.get(address) else { return Ok(0) };
    ensure!(!above.contains(&address), "{} calls itself", function.name);
    let mut used = Use::default();
    for line in &function.code {
        used.add(line);
    }
    ensure!(!used.opaque, "{}: its stack or its calls cannot be told", function.name);
    above.push(address);
    let mut deepest = 0;
    for &call in used.calls.iter().filter(|&&call| call != address) {
        deepest = deepest.max(depth(listing, call, above)?);
    }
    above.pop();
    Ok(used.frame + deepest)
}
