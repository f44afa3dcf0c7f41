//! Most instructions that a function can take, with all it calls: the longest of all paths through its machine code.
//!
//! Every branch is taken both ways, whatever its condition; an instruction in an IT block counts whether it is executed or
//! not. A loop runs as often as a [`Rule`] says. What cannot be told is an error, never a guess: a loop without a rule, one
//! with two entries, a call by pointer, recursion, a branch to nowhere.

use super::listing::{Function, Instruction, Listing};
use anyhow::{Context, Result, bail, ensure};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// How often a loop runs at most.
pub struct Rule {
    /// What the name of the function contains.
    pub function: &'static str,
    /// What the mnemonic of some instruction of the loop begins with.
    pub contains: &'static str,
    /// Most times that its first instruction is executed each time the loop is entered.
    pub times: u64,
}

/// Where control goes from an instruction.
#[derive(Debug, PartialEq, Eq)]
struct Exits {
    /// Within the function.
    to: BTreeSet<u32>,
    /// Function that is called.
    call: Option<u32>,
    /// Whether it may leave the function.
    leaves: bool,
}

/// Instructions that IT, ITT, ... makes conditional.
fn conditional(mnemonic: &str) -> usize {
    let is = |c: char| c == 't' || c == 'e';
    match mnemonic.strip_prefix("it") {
        Some(rest) if rest.chars().all(is) => rest.len() + 1,
        _ => 0,
    }
}

/// The condition of a branch: `None` if the mnemonic is none, `Some(true)` if there is one.
fn branch(mnemonic: &str) -> Option<bool> {
    const CONDITIONS: [&str; 16] = [
        "eq", "ne", "cs", "hs", "cc", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt",
        "le",
    ];
    let plain = mnemonic.trim_end_matches(".n").trim_end_matches(".w");
    match plain {
        "b" => Some(false),
        "cbz" | "cbnz" => Some(true),
        _ => plain.strip_prefix('b').and_then(|c| CONDITIONS.contains(&c).then_some(true)),
    }
}

/// Bytes of a table of branches, which follows the instruction, up to its first target.
fn table(code: &[Instruction], index: usize) -> Result<BTreeSet<u32>> {
    let here = &code[index];
    let size = if here.mnemonic == "tbb" { 1 } else { 2 };
    ensure!(here.operands.starts_with("[pc"), "{:x}: a table that is elsewhere", here.address);
    let from = here.address + 4;
    let bytes: Vec<u8> = code[index + 1..].iter().map_while(Instruction::data).flatten().collect();
    let mut targets = BTreeSet::new();
    for (k, entry) in bytes.chunks_exact(size).enumerate() {
        let place = from + (k * size) as u32;
        if targets.first().is_some_and(|first| place >= *first) {
            break;
        }
        let steps = entry.iter().rev().fold(0, |sum, byte| sum << 8 | u32::from(*byte));
        targets.insert(from + 2 * steps);
    }
    ensure!(!targets.is_empty(), "{:x}: a table without an entry", here.address);
    Ok(targets)
}

/// Whether it loads the program counter from the stack, or branches to the link register.
fn returns(Instruction { mnemonic, operands, .. }: &Instruction) -> bool {
    let pops = mnemonic.starts_with("pop") || mnemonic.starts_with("ldm");
    (pops && operands.contains("pc}"))
        || (mnemonic.starts_with("bx") && operands == "lr")
        || (mnemonic.starts_with("ldr") && operands.starts_with("pc, [sp]"))
}

fn exits(function: &Function, index: usize, in_it: bool) -> Result<Exits> {
    let code = &function.code;
    let here = &code[index];
    let (mnemonic, operands) = (here.mnemonic.as_str(), here.operands.as_str());
    let next = code.get(index + 1).map(|next| next.address);
    let mut exits = Exits { to: BTreeSet::new(), call: None, leaves: false };
    let mut goes_on = true;
    if let Some(depends) = branch(mnemonic) {
        goes_on = depends || in_it;
        let target = here.target().with_context(|| format!("{:x}: where to?", here.address))?;
        if code.iter().any(|other| other.address == target) {
            exits.to.insert(target);
        } else {
            exits.call = Some(target);
            exits.leaves = true;
        }
    } else if mnemonic.starts_with("bl") {
        let target = here.target().filter(|_| !mnemonic.starts_with("blx"));
        exits.call =
            Some(target.with_context(|| format!("{:x}: a call by pointer", here.address))?);
    } else if returns(here) {
        goes_on = in_it;
        exits.leaves = true;
    } else if mnemonic.starts_with("tb") {
        goes_on = false;
        exits.to = table(code, index)?;
    } else if mnemonic.starts_with("udf") {
        goes_on = false;
    } else if mnemonic.starts_with('.')
        || mnemonic.starts_with("bx")
        || operands.starts_with("pc,")
        || operands.contains("pc}")
    {
        bail!("{:x}: {mnemonic} {operands}: where to?", here.address);
    }
    if goes_on {
        exits.to.insert(next.with_context(|| format!("{:x}: runs out", here.address))?);
    }
    Ok(exits)
}

/// A function as a graph of instructions.
struct Graph<'a> {
    function: &'a Function,
    exits: HashMap<u32, Exits>,
    /// Instructions of each, with what it calls.
    cost: HashMap<u32, u64>,
}

type Nodes = BTreeSet<u32>;

impl Graph<'_> {
    fn next(&self, node: u32) -> impl Iterator<Item = u32> {
        self.exits.get(&node).into_iter().flat_map(|exits| exits.to.iter().copied())
    }

    /// The loops among some nodes, an edge back to `entry` not counted, and the nodes in none: the strongly connected
    /// components, each behind those that lead to it (Tarjan 1972, with a stack of its own).
    fn components(&self, nodes: &Nodes, entry: u32) -> Vec<Nodes> {
        let mut order: HashMap<u32, usize> = HashMap::new();
        let mut low: HashMap<u32, usize> = HashMap::new();
        let (mut open, mut found) = (Vec::new(), Vec::new());
        let inner = |node: u32| -> Vec<u32> {
            self.next(node).filter(|to| nodes.contains(to) && *to != entry).collect()
        };
        let mut calls = vec![(entry, inner(entry))];
        order.insert(entry, 0);
        low.insert(entry, 0);
        open.push(entry);
        while let Some((node, left)) = calls.last_mut() {
            let node = *node;
            if let Some(to) = left.pop() {
                if !order.contains_key(&to) {
                    let number = order.len();
                    order.insert(to, number);
                    low.insert(to, number);
                    open.push(to);
                    calls.push((to, inner(to)));
                } else if open.contains(&to) {
                    let least = low[&node].min(order[&to]);
                    low.insert(node, least);
                }
                continue;
            }
            calls.pop();
            if let Some((above, _)) = calls.last() {
                let least = low[above].min(low[&node]);
                low.insert(*above, least);
            }
            if low[&node] == order[&node] {
                let start = open.iter().position(|&other| other == node).unwrap_or(0);
                found.push(open.split_off(start).into_iter().collect());
            }
        }
        found.reverse();
        found
    }

    /// Most instructions from `entry` up to and with each of some nodes, without going back to `entry`.
    fn longest(&self, nodes: &Nodes, entry: u32, rules: &[Rule]) -> Result<HashMap<u32, u64>> {
        let mut before: HashMap<u32, u64> = HashMap::from([(entry, 0)]);
        let mut longest = HashMap::new();
        for part in self.components(nodes, entry) {
            let heads: Vec<u32> =
                part.iter().copied().filter(|node| before.contains_key(node)).collect();
            let &[head] = &heads[..] else {
                bail!("{}: a loop with {} entries", self.function.name, heads.len());
            };
            // Of the entry only what lies before the way back to it.
            let within = if head != entry && self.is_loop(&part) {
                let times = self.times(&part, head, rules)?;
                let within = self.longest(&part, head, rules)?;
                let round = part.iter().filter(|&&node| self.next(node).any(|to| to == head));
                let round = round.map(|node| within[node]).max().unwrap_or(0);
                within.into_iter().map(|(node, sum)| (node, sum + (times - 1) * round)).collect()
            } else {
                HashMap::from([(head, self.cost[&head])])
            };
            for (node, sum) in within {
                let sum = before[&head] + sum;
                longest.insert(node, sum);
                for to in self.next(node).filter(|to| nodes.contains(to) && !part.contains(to)) {
                    let most = before.entry(to).or_insert(0);
                    *most = sum.max(*most);
                }
            }
        }
        Ok(longest)
    }

    /// Whether nodes that lead to each other are a loop.
    fn is_loop(&self, part: &Nodes) -> bool {
        part.len() > 1 || part.iter().any(|&node| self.next(node).any(|to| to == node))
    }

    /// How often a loop runs: by a rule for an instruction of its own, not of a loop in it.
    fn times(&self, part: &Nodes, head: u32, rules: &[Rule]) -> Result<u64> {
        let Function { name, code } = self.function;
        let inner = self.components(part, head);
        let own: Nodes =
            inner.iter().filter(|part| !self.is_loop(part)).flatten().copied().collect();
        let own = if part.len() > 1 { &own } else { part };
        let contains = |start: &str| {
            code.iter().any(|line| own.contains(&line.address) && line.mnemonic.starts_with(start))
        };
        let rule =
            rules.iter().find(|rule| name.contains(rule.function) && contains(rule.contains));
        let rule = rule.with_context(|| format!("{name}: a loop without a bound at {head:x}"))?;
        ensure!(rule.times > 0, "{name}: a loop that never runs");
        Ok(rule.times)
    }
}

/// Most instructions of the function with this name.
pub fn longest(listing: &Listing, entry: &str, rules: &[Rule]) -> Result<u64> {
    let address = listing.find(entry)?;
    let mut known = BTreeMap::new();
    most(listing, address, rules, &mut Vec::new(), &mut known)
}

fn most(
    listing: &Listing,
    address: u32,
    rules: &[Rule],
    above: &mut Vec<u32>,
    known: &mut BTreeMap<u32, u64>,
) -> Result<u64> {
    if let Some(found) = known.get(&address) {
        return Ok(*found);
    }
    let function = listing.get(address).with_context(|| format!("no function at {address:x}"))?;
    ensure!(!above.contains(&address), "{} calls itself", function.name);
    above.push(address);
    let index: HashMap<u32, usize> =
        function.code.iter().enumerate().map(|(k, line)| (line.address, k)).collect();
    let in_it: BTreeSet<usize> = (0..function.code.len())
        .flat_map(|k| k + 1..=k + conditional(&function.code[k].mnemonic))
        .collect();
    let mut graph = Graph { function, exits: HashMap::new(), cost: HashMap::new() };
    let mut reached = vec![address];
    while let Some(node) = reached.pop() {
        if graph.exits.contains_key(&node) {
            continue;
        }
        let k =
            *index.get(&node).with_context(|| format!("{}: no code at {node:x}", function.name))?;
        let exits = exits(function, k, in_it.contains(&k))
            .with_context(|| format!("in {}", function.name))?;
        let called = match exits.call {
            Some(callee) => most(listing, callee, rules, above, known)?,
            None => 0,
        };
        graph.cost.insert(node, 1 + called);
        reached.extend(&exits.to);
        graph.exits.insert(node, exits);
    }
    above.pop();
    let nodes: Nodes = graph.exits.keys().copied().collect();
    // A loop may begin with the first instruction: what comes before the function leads to it.
    ensure!(
        !nodes.iter().any(|&node| graph.next(node).any(|to| to == address)),
        "{}: its first instruction is a loop's",
        function.name
    );
    let longest = graph.longest(&nodes, address, rules)?;
    let ends = nodes.iter().filter(|node| graph.exits[*node].leaves).map(|node| longest[node]);
    let found = ends.max().with_context(|| format!("{} never returns", function.name))?;
    known.insert(address, found);
    Ok(found)
}
