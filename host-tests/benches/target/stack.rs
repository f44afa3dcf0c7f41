//! Greatest stack of a function with all it calls, from a disassembly (GNU objdump of Thumb-2 code).

use anyhow::{Context, Result, ensure};
use std::collections::{BTreeMap, BTreeSet};

#[derive(Default)]
struct Function {
    name: String,
    frame: u32,
    calls: BTreeSet<u32>,
    /// It calls by pointer, or moves the stack pointer by a register.
    opaque: bool,
}

pub struct Stacks {
    functions: BTreeMap<u32, Function>,
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

impl Function {
    fn add(&mut self, mnemonic: &str, operands: &str) {
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
            && let Some((before, name)) = operands.split_once(" <")
            && !name.contains("+0x")
            && let Some(address) = before.rsplit([' ', ',']).next()
            && let Ok(address) = u32::from_str_radix(address, 16)
        {
            self.calls.insert(address);
        }
    }
}

impl Stacks {
    pub fn read(text: &str) -> Result<Self> {
        let mut functions = BTreeMap::new();
        let mut current: Option<(u32, Function)> = None;
        for line in text.lines() {
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|l| l.split_once(" <"))
            {
                functions.extend(current.take());
                let address = u32::from_str_radix(address, 16)?;
                current =
                    Some((address, Function { name: name.to_owned(), ..Function::default() }));
            } else if let Some((_, function)) = &mut current {
                let mut parts = line.split('\t').skip(1);
                let mnemonic = parts.next().unwrap_or("").trim();
                function.add(mnemonic, parts.next().unwrap_or(""));
            }
        }
        functions.extend(current);
        ensure!(!functions.is_empty(), "the disassembly is empty");
        Ok(Self { functions })
    }

    /// Most bytes that the function with this name needs, with all it calls.
    pub fn worst(&self, entry: &str) -> Result<u32> {
        let found = self.functions.iter().find(|(_, function)| function.name == entry);
        let (&address, _) = found.with_context(|| format!("there is no {entry}"))?;
        self.depth(address, &mut Vec::new())
    }

    fn depth(&self, address: u32, above: &mut Vec<u32>) -> Result<u32> {
        let Some(function) = self.functions.get(&address) else { return Ok(0) };
        ensure!(!above.contains(&address), "{} calls itself", function.name);
        ensure!(!function.opaque, "{}: its stack or its calls cannot be told", function.name);
        above.push(address);
        let mut deepest = 0;
        for &call in function.calls.iter().filter(|&&call| call != address) {
            deepest = deepest.max(self.depth(call, above)?);
        }
        above.pop();
        Ok(function.frame + deepest)
    }
}
