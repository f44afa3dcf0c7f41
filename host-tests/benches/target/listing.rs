//! Functions and instructions of a disassembly (GNU objdump of Thumb-2 code, `-d -C --no-show-raw-insn`).

use anyhow::{Context, Result, ensure};
use std::collections::BTreeMap;

/// One line of code, or of data among it.
pub struct Instruction {
    pub address: u32,
    pub mnemonic: String,
    pub operands: String,
}

impl Instruction {
    /// Address that a branch or a call names.
    pub fn target(&self) -> Option<u32> {
        let (before, _) = self.operands.split_once(" <")?;
        u32::from_str_radix(before.rsplit([' ', ',']).next()?, 16).ok()
    }

    /// The bytes, if it is data.
    pub fn data(&self) -> Option<Vec<u8>> {
        let size = match self.mnemonic.as_str() {
            ".word" => 4,
            ".short" => 2,
            ".byte" => 1,
            _ => return None,
        };
        let value = u32::from_str_radix(self.operands.strip_prefix("0x")?, 16).ok()?;
        Some(value.to_le_bytes()[..size].to_vec())
    }
}

pub struct Function {
    pub name: String,
    pub code: Vec<Instruction>,
}

/// Functions by address.
pub struct Listing {
    functions: BTreeMap<u32, Function>,
}

impl Listing {
    pub fn read(text: &str) -> Result<Self> {
        let mut functions = BTreeMap::new();
        let mut current: Option<(u32, Function)> = None;
        for line in text.lines() {
            if let Some((address, name)) = line.strip_suffix(">:").and_then(|l| l.split_once(" <"))
            {
                functions.extend(current.take());
                let address = u32::from_str_radix(address, 16)?;
                current = Some((address, Function { name: name.to_owned(), code: Vec::new() }));
            } else if let Some((_, function)) = &mut current
                && let Some((address, rest)) = line.split_once(":\t")
                && let Ok(address) = u32::from_str_radix(address.trim(), 16)
            {
                let mut words = rest.split('\t');
                let mut word = || words.next().unwrap_or("").trim().to_owned();
                let (mnemonic, operands) = (word(), word());
                function.code.push(Instruction { address, mnemonic, operands });
            }
        }
        functions.extend(current);
        ensure!(!functions.is_empty(), "the disassembly is empty");
        Ok(Self { functions })
    }

    pub fn get(&self, address: u32) -> Option<&Function> {
        self.functions.get(&address)
    }

    /// Address of the function with this name.
    pub fn find(&self, name: &str) -> Result<u32> {
        let found = self.functions.iter().find(|(_, function)| function.name == name);
        found.map(|(&address, _)| address).with_context(|| format!("there is no {name}"))
    }
}
