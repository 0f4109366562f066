//! Specialises the constants of SPIR-V before it reaches the driver.
//!
//! One entry point contains every technique, light and type of surface, but a pipeline needs only a third of it. Drivers translate
//! all of the code before they remove dead code. For each pipeline that filters and shades, this took llvmpipe a second, and
//! llvmpipe has no cache to avoid it. Specialisation takes milliseconds. Constants are propagated along reachable edges (Wegman and
//! Zadeck 1991), through calls, returned values and local variables. Then unreachable blocks and uncalled functions are removed.
//! All other instructions stay unchanged.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use super::fold::{self, Kind, fold};
use super::{BOUND, HEADER, Instruction, OP_LOOP_MERGE, all_instructions, instructions};

const OP_NAME: u32 = 5;
const OP_TYPE_BOOL: u32 = 20;
const OP_TYPE_INT: u32 = 21;
const OP_TYPE_FLOAT: u32 = 22;
const OP_CONSTANT_TRUE: u32 = 41;
const OP_CONSTANT_FALSE: u32 = 42;
const OP_CONSTANT: u32 = 43;
const OP_SPEC_CONSTANT_TRUE: u32 = 48;
const OP_SPEC_CONSTANT_FALSE: u32 = 49;
const OP_SPEC_CONSTANT: u32 = 50;
const OP_SPEC_CONSTANT_OP: u32 = 52;
const OP_ENTRY_POINT: u32 = 15;
const OP_FUNCTION: u32 = 54;
const OP_FUNCTION_PARAMETER: u32 = 55;
const OP_FUNCTION_END: u32 = 56;
const OP_FUNCTION_CALL: u32 = 57;
const OP_VARIABLE: u32 = 59;
const OP_LOAD: u32 = 61;
const OP_STORE: u32 = 62;
const OP_DECORATE: u32 = 71;
const OP_UNDEF: u32 = 1;
const OP_PHI: u32 = 245;
const OP_SELECTION_MERGE: u32 = 247;
const OP_LABEL: u32 = 248;
const OP_BRANCH: u32 = 249;
const OP_BRANCH_CONDITIONAL: u32 = 250;
const OP_SWITCH: u32 = 251;
const OP_RETURN_VALUE: u32 = 254;
const OP_UNREACHABLE: u32 = 255;
const OP_NO_LINE: u32 = 317;
const OP_TERMINATE_INVOCATION: u32 = 4416;
const OP_DEMOTE: u32 = 5380;
const SPEC_ID: u32 = 1;

/// The value of an identifier in constant propagation, as an element of a lattice.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    /// No path has reached the value so far.
    Nothing,
    Value(u32),
    /// The value is not a constant.
    Varies,
}

impl Known {
    /// Returns the meet of two lattice values.
    fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Nothing, known) | (known, Self::Nothing) => known,
            (Self::Value(a), Self::Value(b)) if a == b => self,
            _ => Self::Varies,
        }
    }
}

/// Data about the identifiers of a module.
struct Globals {
    /// The lattice value of each identifier. For a function's variable, it belongs to the content, and for a function, to the
    /// result.
    known: Vec<Known>,
    /// The index of each label's block within its function.
    block_indices: Vec<Option<usize>>,
    /// Whether each identifier is a function variable, or a parameter that may point to one.
    addresses: Vec<bool>,
    kinds: Vec<Option<Kind>>,
    /// Whether each identifier was removed.
    lost: Vec<bool>,
}

struct Block {
    label: u32,
    /// The range of the block's words, from its label to the end of its last instruction.
    words: Range<usize>,
    /// The start of the last instruction. `merge` is the start of the merge instruction, if there is one.
    last: usize,
    merge: Option<usize>,
    reached: bool,
    /// The labels of the block's predecessors along reachable edges.
    before: Vec<u32>,
}

/// Returns the module with specialised constants and without unreachable code. `value` returns the value for a constant's number,
/// or `None` for its default. In a module with unsupported functions, only the constants are specialised.
pub fn specialized(module: &[u32], value: impl Fn(u32) -> Option<u32>) -> Vec<u32> {
    let Some(bound) = module.get(BOUND).filter(|_| module.len() >= HEADER).map(|bound| *bound as usize) else {
        return module.to_vec();
    };
    let mut out = module[..HEADER].to_vec();
    let mut globals = Globals {
        known: vec![Known::Varies; bound],
        block_indices: vec![None; bound],
        addresses: vec![false; bound],
        lost: vec![false; bound],
        kinds: vec![None; bound],
    };
    let at = specialize_constants(module, value, &mut globals, &mut out);
    let Some(mut functions) = parse_functions(module, at, &mut globals) else {
        out.extend_from_slice(&module[at..]);
        return out;
    };
    follow(module, &mut functions, &mut globals);
    let (mut fresh, mut undefined) = (bound as u32, Vec::new());
    let mut bodies = Vec::new();
    for function in &functions {
        function.write(module, &mut globals, &mut bodies, &mut |kind| {
            undefined.extend([3 << 16 | OP_UNDEF, kind, fresh]);
            fresh += 1;
            fresh - 1
        });
    }
    out.extend(undefined);
    out.extend(bodies);
    out[BOUND] = fresh;
    without_lost_names(&out, &globals.lost)
}

/// Parses the functions from word `from` on, and marks entry points as reached. Returns `None` if a function contains unsupported
/// instructions.
fn parse_functions(module: &[u32], from: usize, globals: &mut Globals) -> Option<Vec<Function>> {
    let entry_points = all_instructions(module).take_while(|i| i.operation != OP_FUNCTION);
    let entered: Vec<u32> =
        entry_points.filter(|i| i.operation == OP_ENTRY_POINT).filter_map(|i| i.words.get(2).copied()).collect();
    let (mut functions, mut at) = (Vec::new(), from);
    while at < module.len() {
        let end = instructions(module, at).find(|i| i.operation == OP_FUNCTION_END).map(|i| i.at + i.words.len())?;
        let mut function = Function::parse(module, at..end, globals)?;
        function.reached = entered.contains(&function.id);
        functions.push(function);
        at = end;
    }
    invalidate_escaping_variables(module, from, &functions, globals);
    Some(functions)
}

/// Marks a variable or parameter as varying if its address is used by anything but loads and stores of its own function.
fn invalidate_escaping_variables(module: &[u32], from: usize, functions: &[Function], globals: &mut Globals) {
    let mut written = Vec::new();
    let mut passed = Vec::new();
    for i in instructions(module, from) {
        match i.operation {
            OP_VARIABLE | OP_LOAD | OP_FUNCTION_PARAMETER => (),
            // A literal operand may have the same number as an identifier, which only makes the result less precise.
            OP_STORE => written.extend([(i.words[2], true), (i.words[1], false)]),
            OP_FUNCTION_CALL => passed.push(i.words),
            OP_RETURN_VALUE => written.push((i.words[1], true)),
            _ => written.extend(i.words[1..].iter().map(|&id| (id, true))),
        }
    }
    let is_address = |globals: &Globals, id: u32| globals.addresses.get(id as usize) == Some(&true);
    let parameters: HashSet<u32> = functions.iter().flat_map(|function| &function.parameters).copied().collect();
    for (id, anyhow) in written {
        // A store to a parameter writes the caller's variable.
        if is_address(globals, id) && (anyhow || parameters.contains(&id)) {
            globals.known[id as usize] = Known::Varies;
        }
    }
    let by_id: HashMap<u32, &Function> = functions.iter().map(|function| (function.id, function)).collect();
    // An argument keeps its value if the parameter is only read. The loop proceeds from the innermost call outwards.
    loop {
        let mut changed = false;
        for call in &passed {
            let called = by_id.get(&call[3]);
            for (i, &id) in call[4..].iter().enumerate() {
                let read_only = called
                    .and_then(|called| called.parameters.get(i))
                    .is_some_and(|parameter| globals.of(*parameter) != Known::Varies);
                if is_address(globals, id) && !read_only && globals.of(id) != Known::Varies {
                    globals.known[id as usize] = Known::Varies;
                    changed = true;
                }
            }
        }
        if !changed {
            return;
        }
    }
}

/// Finds the reachable code and the constants in it.
fn follow(module: &[u32], functions: &mut [Function], globals: &mut Globals) {
    let by_id: HashMap<u32, usize> = functions.iter().enumerate().map(|(i, function)| (function.id, i)).collect();
    loop {
        let mut changed = false;
        for at in 0..functions.len() {
            if !functions[at].reached {
                continue;
            }
            let mut calls = Vec::new();
            changed |= functions[at].follow(module, globals, &mut calls);
            for call in calls {
                let Some(called) = by_id.get(&call[3]).map(|&called| &mut functions[called]) else { continue };
                changed |= !called.reached;
                called.reached = true;
                for (&parameter, &given) in called.parameters.iter().zip(&call[4..]) {
                    changed |= globals.learn(parameter, globals.of(given));
                }
            }
        }
        // A branch on an undefined value may take any target.
        if !changed && !functions.iter().filter(|function| function.reached).any(|f| f.open_choices(module, globals)) {
            return;
        }
    }
}

/// Writes the words before the first function, with specialised constants, and returns the start of the functions.
fn specialize_constants(
    module: &[u32],
    value: impl Fn(u32) -> Option<u32>,
    globals: &mut Globals,
    out: &mut Vec<u32>,
) -> usize {
    let spec_id = |i: &Instruction<'_>| i.operation == OP_DECORATE && i.words.get(2) == Some(&SPEC_ID);
    let mut given = vec![None; globals.known.len()];
    for i in all_instructions(module).take_while(|i| i.operation != OP_FUNCTION).filter(spec_id) {
        given[i.words[1] as usize] = value(i.words[3]);
    }
    for i in all_instructions(module) {
        let words = i.words;
        match i.operation {
            OP_FUNCTION => return i.at,
            OP_DECORATE if spec_id(&i) => continue,
            OP_TYPE_BOOL => globals.kinds[words[1] as usize] = Some(Kind::Bool),
            OP_TYPE_INT if words[2] == 32 => globals.kinds[words[1] as usize] = Some(Kind::Int),
            OP_TYPE_FLOAT if words[2] == 32 => globals.kinds[words[1] as usize] = Some(Kind::Float),
            OP_CONSTANT_TRUE | OP_CONSTANT_FALSE | OP_SPEC_CONSTANT_TRUE | OP_SPEC_CONSTANT_FALSE => {
                let default = u32::from(matches!(i.operation, OP_CONSTANT_TRUE | OP_SPEC_CONSTANT_TRUE));
                let bits = given[words[2] as usize].unwrap_or(default);
                globals.known[words[2] as usize] = Known::Value(bits);
                push_constant(Kind::Bool, words[1], words[2], bits, out);
                continue;
            }
            OP_CONSTANT | OP_SPEC_CONSTANT if words.len() == 4 => {
                let bits = given[words[2] as usize].unwrap_or(words[3]);
                if globals.kinds[words[1] as usize].is_some() {
                    globals.known[words[2] as usize] = Known::Value(bits);
                }
                out.extend([4 << 16 | OP_CONSTANT, words[1], words[2], bits]);
                continue;
            }
            OP_SPEC_CONSTANT_OP => {
                if let (Known::Value(bits), Some(kind)) =
                    (globals.folded(words[1], words[3], &words[4..]), globals.kinds[words[1] as usize])
                {
                    globals.known[words[2] as usize] = Known::Value(bits);
                    push_constant(kind, words[1], words[2], bits, out);
                    continue;
                }
                globals.known[words[2] as usize] = Known::Varies;
            }
            _ => (),
        }
        out.extend_from_slice(words);
    }
    module.len()
}

fn push_constant(kind: Kind, of_type: u32, id: u32, bits: u32, out: &mut Vec<u32>) {
    match kind {
        Kind::Bool => out.extend([3 << 16 | if bits == 0 { OP_CONSTANT_FALSE } else { OP_CONSTANT_TRUE }, of_type, id]),
        Kind::Int | Kind::Float => out.extend([4 << 16 | OP_CONSTANT, of_type, id, bits]),
    }
}

impl Globals {
    /// Returns the lattice value of an operation with this result type.
    fn folded(&self, of_type: u32, operation: u32, operands: &[u32]) -> Known {
        let scalar = self.kinds.get(of_type as usize).copied().flatten().is_some();
        if !scalar || !fold::is_known(operation) || operands.len() > 3 {
            return Known::Varies;
        }
        let of =
            |i: usize| operands.get(i).and_then(|&id| self.known.get(id as usize)).copied().unwrap_or(Known::Varies);
        let all = [of(0), of(1), of(2)];
        let values = all.map(|known| if let Known::Value(bits) = known { Some(bits) } else { None });
        match fold(operation, values) {
            Some(bits) => Known::Value(bits),
            None if all[..operands.len()].contains(&Known::Nothing) => Known::Nothing,
            None => Known::Varies,
        }
    }

    fn of(&self, id: u32) -> Known {
        self.known[id as usize]
    }

    /// Merges `known` into the lattice value of an identifier. Returns whether the value changed.
    fn learn(&mut self, id: u32, known: Known) -> bool {
        let slot = &mut self.known[id as usize];
        let before = std::mem::replace(slot, slot.or(known));
        before != *slot
    }

    /// Registers a function variable or a parameter that has no value so far.
    fn add_variable(&mut self, words: &[u32]) -> Option<()> {
        let (of_type, id) = (*words.get(1)? as usize, *words.get(2)? as usize);
        *self.known.get_mut(id)? = Known::Nothing;
        // A parameter that is not a pointer is never written.
        self.addresses[id] = self.kinds.get(of_type)?.is_none();
        Some(())
    }

    fn block(&self, label: u32) -> usize {
        self.block_indices[label as usize].unwrap_or(0)
    }
}

/// A function during the analysis.
struct Function {
    id: u32,
    parameters: Vec<u32>,
    reached: bool,
    /// The words before the first block. `tail` holds the words after the last block.
    head: Range<usize>,
    tail: Range<usize>,
    blocks: Vec<Block>,
}

fn ends_block(operation: u32) -> bool {
    (OP_BRANCH..=OP_UNREACHABLE).contains(&operation) || operation == OP_TERMINATE_INVOCATION
}

impl Function {
    /// Parses the function in these words. Returns `None` if it contains unsupported instructions.
    fn parse(module: &[u32], words: Range<usize>, globals: &mut Globals) -> Option<Self> {
        let mut blocks: Vec<Block> = Vec::new();
        let (mut id, mut parameters) = (0, Vec::new());
        let mut open = false;
        let (mut head, mut tail) = (words.start..words.start, words.end..words.end);
        for i in instructions(&module[..words.end], words.start) {
            match i.operation {
                OP_LABEL => {
                    if open {
                        return None;
                    }
                    open = true;
                    if blocks.is_empty() {
                        head.end = i.at;
                    }
                    *globals.block_indices.get_mut(*i.words.get(1)? as usize)? = Some(blocks.len());
                    blocks.push(Block {
                        label: i.words[1],
                        words: i.at..i.at,
                        last: i.at,
                        merge: None,
                        reached: false,
                        before: Vec::new(),
                    });
                }
                OP_FUNCTION => {
                    id = *i.words.get(2)?;
                    *globals.known.get_mut(id as usize)? = Known::Nothing;
                }
                OP_FUNCTION_PARAMETER => {
                    parameters.push(*i.words.get(2)?);
                    globals.add_variable(i.words)?;
                }
                OP_FUNCTION_END => tail.start = i.at,
                _ if !open => (),
                OP_VARIABLE => globals.add_variable(i.words)?,
                OP_LOOP_MERGE | OP_SELECTION_MERGE => blocks.last_mut()?.merge = Some(i.at),
                operation if ends_block(operation) => {
                    let block = blocks.last_mut()?;
                    block.last = i.at;
                    block.words.end = i.at + i.words.len();
                    open = false;
                }
                operation if matches!(operation, OP_PHI | OP_LOAD | OP_FUNCTION_CALL) || fold::is_known(operation) => {
                    *globals.known.get_mut(*i.words.get(2)? as usize)? = Known::Nothing;
                }
                _ => (),
            }
        }
        (!open && !blocks.is_empty()).then_some(Self { id, parameters, reached: false, head, tail, blocks })
    }

    /// Returns the only target of the conditional branch at the end of a block. Returns `None` for a branch that closes a loop,
    /// because such a branch stays unchanged.
    fn always(&self, module: &[u32], block: usize, globals: &Globals) -> Option<u32> {
        let i = last_of(module, &self.blocks[block]);
        match (i.operation == OP_BRANCH_CONDITIONAL).then(|| globals.of(i.words[1]))? {
            Known::Value(bits) if !self.closes_loop(module, block, globals) => {
                Some(i.words[if bits != 0 { 2 } else { 3 }])
            }
            _ => None,
        }
    }

    /// Returns the reachable successors of a block. A back edge to a loop header always counts, because a loop must have a back
    /// edge.
    fn targets(&self, module: &[u32], block: usize, globals: &Globals) -> Vec<u32> {
        let i = last_of(module, &self.blocks[block]);
        match i.operation {
            OP_BRANCH => vec![i.words[1]],
            OP_BRANCH_CONDITIONAL if globals.of(i.words[1]) == Known::Nothing => Vec::new(),
            OP_BRANCH_CONDITIONAL => {
                self.always(module, block, globals).map_or_else(|| i.words[2..4].to_vec(), |taken| vec![taken])
            }
            OP_SWITCH => match globals.of(i.words[1]) {
                Known::Nothing => Vec::new(),
                Known::Value(bits) => vec![case_of(i.words, bits)],
                Known::Varies => i.words[2..3].iter().chain(i.words[3..].iter().skip(1).step_by(2)).copied().collect(),
            },
            _ => Vec::new(),
        }
    }

    /// Whether a block branches to the header of an enclosing loop.
    fn closes_loop(&self, module: &[u32], block: usize, globals: &Globals) -> bool {
        last_of(module, &self.blocks[block]).words[2..4].iter().any(|label| globals.block(*label) <= block)
    }

    /// Finds reachable code and calls from the current values of parameters and results. Returns whether anything changed.
    fn follow<'a>(&mut self, module: &'a [u32], globals: &mut Globals, calls: &mut Vec<&'a [u32]>) -> bool {
        self.blocks[0].reached = true;
        let mut any = false;
        loop {
            let mut changed = false;
            calls.clear();
            for block in 0..self.blocks.len() {
                if self.blocks[block].reached {
                    changed |= self.visit(module, block, globals, calls);
                }
            }
            if !changed {
                return any;
            }
            any = true;
        }
    }

    /// Marks unknown branch conditions as varying, and returns whether there are any.
    fn open_choices(&self, module: &[u32], globals: &mut Globals) -> bool {
        let mut opened = false;
        for block in self.blocks.iter().filter(|block| block.reached) {
            let i = last_of(module, block);
            if matches!(i.operation, OP_BRANCH_CONDITIONAL | OP_SWITCH) && globals.of(i.words[1]) == Known::Nothing {
                opened |= globals.learn(i.words[1], Known::Varies);
            }
        }
        opened
    }

    fn visit<'a>(
        &mut self,
        module: &'a [u32],
        block: usize,
        globals: &mut Globals,
        calls: &mut Vec<&'a [u32]>,
    ) -> bool {
        let mut changed = false;
        let Block { words, before, .. } = &self.blocks[block];
        for i in instructions(&module[..words.end], words.start) {
            let known = match i.operation {
                OP_PHI => {
                    let pairs = i.words[3..].as_chunks::<2>().0;
                    let taken = pairs.iter().filter(|[_, from]| before.contains(from));
                    taken.fold(Known::Nothing, |known, [value, _]| known.or(globals.of(*value)))
                }
                OP_LOAD => globals.of(i.words[3]),
                OP_FUNCTION_CALL => {
                    calls.push(i.words);
                    globals.of(i.words[3])
                }
                OP_STORE => {
                    changed |= globals.learn(i.words[1], globals.of(i.words[2]));
                    continue;
                }
                OP_VARIABLE if i.words.len() > 4 => {
                    changed |= globals.learn(i.words[2], globals.of(i.words[4]));
                    continue;
                }
                OP_RETURN_VALUE => {
                    changed |= globals.learn(self.id, globals.of(i.words[1]));
                    continue;
                }
                operation if fold::is_known(operation) => globals.folded(i.words[1], operation, &i.words[3..]),
                _ => continue,
            };
            changed |= globals.learn(i.words[2], known);
        }
        let label = self.blocks[block].label;
        for target in self.targets(module, block, globals) {
            let next = globals.block(target);
            let next = &mut self.blocks[next];
            if !next.before.contains(&label) {
                next.before.push(label);
                changed = true;
            }
            next.reached = true;
        }
        changed
    }

    /// Writes the reachable code. `undefined` returns the identifier of an undefined value of a type.
    fn write(&self, module: &[u32], globals: &mut Globals, out: &mut Vec<u32>, undefined: &mut impl FnMut(u32) -> u32) {
        if !self.reached {
            let gone = instructions(&module[..self.tail.end], self.head.start);
            gone.filter_map(|i| result_of(&i)).for_each(|id| globals.lost[id as usize] = true);
            return;
        }
        // Blocks named in merge instructions must exist, even if they are unreachable.
        let mut named: Vec<Option<u32>> = vec![None; self.blocks.len()];
        for block in self.blocks.iter().filter(|block| block.reached) {
            let Some(merge) = block.merge.filter(|_| !self.has_constant_branch(module, block, globals)) else {
                continue;
            };
            let words = &module[merge..];
            let rest = globals.block(words[1]);
            named[rest] = named[rest].or(Some(OP_UNREACHABLE));
            if words[0] & 0xffff == OP_LOOP_MERGE {
                named[globals.block(words[2])] = Some(block.label);
            }
        }
        out.extend_from_slice(&module[self.head.clone()]);
        for (block, named) in self.blocks.iter().zip(&named) {
            match named {
                _ if block.reached => self.write_block(module, block, globals, out, undefined),
                Some(OP_UNREACHABLE) => out.extend([2 << 16 | OP_LABEL, block.label, 1 << 16 | OP_UNREACHABLE]),
                Some(head) => out.extend([2 << 16 | OP_LABEL, block.label, 2 << 16 | OP_BRANCH, *head]),
                None => (),
            }
            if !block.reached {
                let gone =
                    instructions(&module[..block.words.end], block.words.start).skip(usize::from(named.is_some()));
                gone.filter_map(|i| result_of(&i)).for_each(|id| globals.lost[id as usize] = true);
            }
        }
        out.extend_from_slice(&module[self.tail.clone()]);
    }

    /// Whether a block ends in a conditional branch that always has the same target.
    fn has_constant_branch(&self, module: &[u32], block: &Block, globals: &Globals) -> bool {
        self.always(module, globals.block(block.label), globals).is_some()
            && block.merge.is_none_or(|merge| module[merge] & 0xffff == OP_SELECTION_MERGE)
    }

    fn write_block(
        &self,
        module: &[u32],
        block: &Block,
        globals: &Globals,
        out: &mut Vec<u32>,
        undefined: &mut impl FnMut(u32) -> u32,
    ) {
        let always = self.always(module, globals.block(block.label), globals);
        let constant_branch = self.has_constant_branch(module, block, globals);
        // A loop with an unreachable continue block keeps its back edge, because SPIR-V requires one.
        let lost_end =
            block.merge.filter(|&merge| module[merge] & 0xffff == OP_LOOP_MERGE).map(|merge| module[merge + 2]);
        let lost_end = lost_end.filter(|label| !self.blocks[globals.block(*label)].reached);
        for i in instructions(&module[..block.words.end], block.words.start) {
            match i.operation {
                OP_PHI => {
                    let pairs = i.words[3..].as_chunks::<2>().0;
                    let start = out.len();
                    out.extend([OP_PHI, i.words[1], i.words[2]]);
                    out.extend(pairs.iter().filter(|[_, from]| block.before.contains(from)).flatten());
                    if let Some(label) = lost_end {
                        out.extend([undefined(i.words[1]), label]);
                    }
                    out[start] |= ((out.len() - start) as u32) << 16;
                }
                OP_SELECTION_MERGE if constant_branch => (),
                OP_BRANCH_CONDITIONAL => match always {
                    Some(taken) => out.extend([2 << 16 | OP_BRANCH, taken]),
                    None => out.extend_from_slice(i.words),
                },
                OP_SWITCH => match globals.of(i.words[1]) {
                    // Nested constructs may break out of a switch, so it stays a switch.
                    Known::Value(bits) => out.extend([3 << 16 | OP_SWITCH, i.words[1], case_of(i.words, bits)]),
                    _ => out.extend_from_slice(i.words),
                },
                _ => out.extend_from_slice(i.words),
            }
        }
    }
}

fn last_of<'a>(module: &'a [u32], block: &Block) -> Instruction<'a> {
    let words = &module[block.last..block.words.end];
    Instruction { operation: words[0] & 0xffff, at: block.last, words }
}

/// Returns the target of a switch for a value.
fn case_of(words: &[u32], value: u32) -> u32 {
    let cases = words[3..].as_chunks::<2>().0;
    cases.iter().find(|[case, _]| *case == value).map_or(words[2], |[_, label]| *label)
}

/// Returns the result identifier of an instruction in a function.
fn result_of(i: &Instruction<'_>) -> Option<u32> {
    match i.operation {
        OP_LABEL => i.words.get(1).copied(),
        OP_NO_LINE
        | 0
        | 8
        | 62
        | 63
        | 99
        | 218..=221
        | 224
        | 225
        | 228
        | OP_LOOP_MERGE
        | OP_SELECTION_MERGE
        | OP_DEMOTE => None,
        operation if ends_block(operation) => None,
        _ => i.words.get(2).copied(),
    }
}

/// Returns the module without the names and decorations of removed identifiers.
fn without_lost_names(module: &[u32], lost: &[bool]) -> Vec<u32> {
    let mut out = module[..HEADER].to_vec();
    for i in all_instructions(module) {
        let named = matches!(i.operation, OP_NAME | OP_DECORATE).then(|| i.words.get(1)).flatten();
        if named.is_none_or(|&id| lost.get(id as usize) != Some(&true)) {
            out.extend_from_slice(i.words);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::shaders::{ConstantKind, Shader};

    /// Returns the shaders of the renderer and the probes.
    fn shaders() -> impl Iterator<Item = &'static Shader> {
        leadr_shaders::SHADERS.iter().chain(leadr_probes::PROBES)
    }

    fn shader(name: &str) -> &'static Shader {
        shaders().find(|shader| shader.name == name).unwrap()
    }

    /// Returns the inconsistencies in the functions of a module.
    fn faults(module: &[u32]) -> Vec<String> {
        let mut faults = Vec::new();
        let mut before: BTreeMap<u32, BTreeSet<u32>> = BTreeMap::new();
        let (mut labels, mut merges, mut phis) = (BTreeSet::new(), Vec::new(), Vec::new());
        let (mut label, mut open) = (0, false);
        for i in all_instructions(module) {
            let mut goes_to = |targets: &[u32]| {
                targets.iter().for_each(|target| _ = before.entry(*target).or_default().insert(label));
            };
            match i.operation {
                OP_LABEL => {
                    if open || !labels.insert(i.words[1]) {
                        faults.push(format!("block {} starts inside another, or twice", i.words[1]));
                    }
                    (label, open) = (i.words[1], true);
                }
                OP_PHI => phis
                    .push((label, i.words[3..].as_chunks::<2>().0.iter().map(|pair| pair[1]).collect::<BTreeSet<_>>())),
                OP_LOOP_MERGE => merges.extend(&i.words[1..3]),
                OP_SELECTION_MERGE => merges.push(i.words[1]),
                OP_BRANCH => goes_to(&i.words[1..2]),
                OP_BRANCH_CONDITIONAL => goes_to(&i.words[2..4]),
                OP_SWITCH => {
                    goes_to(&i.words[2..3]);
                    i.words[3..].as_chunks::<2>().0.iter().for_each(|case| goes_to(&case[1..]));
                }
                OP_DECORATE if i.words[2] == SPEC_ID => faults.push("a constant still has a number".to_owned()),
                OP_SPEC_CONSTANT | OP_SPEC_CONSTANT_TRUE | OP_SPEC_CONSTANT_FALSE => {
                    faults.push(format!("constant {} is not specialised", i.words[2]));
                }
                _ => (),
            }
            open &= !ends_block(i.operation);
        }
        let targets: BTreeSet<u32> = before.keys().copied().chain(merges).collect();
        faults.extend(targets.difference(&labels).map(|lost| format!("{lost} does not exist")));
        let none = BTreeSet::new();
        for (label, from) in phis {
            let expected = before.get(&label).unwrap_or(&none);
            if from != *expected {
                faults.push(format!("block {label} takes values from {from:?}, but follows {expected:?}"));
            }
        }
        faults
    }

    /// Returns the number of each constant together with several test values.
    fn settings(shader: &Shader) -> Vec<(u32, u32)> {
        let of = |kind| match kind {
            ConstantKind::Bool => 0..2,
            ConstantKind::U32 | ConstantKind::I32 => 0..6,
            ConstantKind::F32 => 0..0,
        };
        shader
            .interface()
            .constants
            .iter()
            .flat_map(|constant| of(constant.kind).map(|value| (constant.id, value)))
            .collect()
    }

    #[test]
    #[ignore = "long"]
    fn all_specialisations_stay_valid() {
        let mut smaller = 0;
        for shader in shaders() {
            let name = shader.name;
            let module = shader.words();
            let open = |fault: &String| fault.contains("constant");
            assert_eq!(faults(&module).iter().find(|fault| !open(fault)), None, "{name} as it was compiled");
            for (id, value) in settings(shader).into_iter().chain([(u32::MAX, 0)]) {
                let special = specialized(&module, |constant| (constant == id).then_some(value));
                assert_eq!(faults(&special).first(), None, "{name} with constant {id} at {value}");
                assert_eq!(faults(&specialized(&special, |_| None)).first(), None, "{name}, specialised twice");
                smaller += usize::from(special.len() < module.len());
            }
        }
        assert!(smaller > 100, "{smaller}");
    }

    #[test]
    fn unreachable_code_is_removed() {
        let shader = shader("passes/filter/filter_shade.frag");
        let module = shader.words();
        let of = |family: u32| {
            let constant = shader.interface().constants.iter().find(|constant| constant.name == "FAMILY").unwrap();
            specialized(&module, |id| (id == constant.id).then_some(family)).len()
        };
        // Value 0 means no light at all, and value 4 means LEADR.
        assert!(of(0) < of(4) && of(4) < module.len(), "{} {} {}", of(0), of(4), module.len());
    }

    #[test]
    fn functions_that_are_not_called_are_left_out() {
        let shader = shader("probes/selftest/selftest_branches.comp");
        let module = shader.words();
        let functions = |early: u32, limit: f32| {
            let special = specialized(&module, |id| match id {
                1 => Some(early),
                2 => Some(limit.to_bits()),
                _ => None,
            });
            all_instructions(&special).filter(|i| i.operation == OP_FUNCTION).count()
        };
        // If `main` returns at once, it is the only function left. `looped` is called in either case.
        assert_eq!(functions(0, -1.0), 1);
        assert_eq!(functions(0, 1.0), functions(1, 1.0));
        assert!(functions(0, 1.0) > 5);
    }

    #[test]
    fn lost_edges_and_open_constants_are_noticed() {
        let shader = shader("probes/selftest/selftest_branches.comp");
        let module = shader.words();
        assert!(faults(&module).iter().any(|fault| fault.contains("is not specialised")));
        let special = specialized(&module, |_| None);
        let label = all_instructions(&special).filter(|i| i.operation == OP_LABEL).last().unwrap();
        let mut broken = special.clone();
        broken[label.at + 1] = 0;
        assert!(faults(&broken).iter().any(|fault| fault.contains("does not exist")));
        let special = specialized(&self::shader("passes/filter/filter.frag").words(), |_| None);
        let phi = all_instructions(&special).find(|i| i.operation == OP_PHI).expect("a choice of two values");
        let mut broken = special.clone();
        broken[phi.at + 4] = 0;
        assert!(faults(&broken).iter().any(|fault| fault.contains("takes values")));
    }

    #[test]
    fn no_module_is_too_short() {
        let module = shader("probes/selftest/selftest_branches.comp").words();
        for words in 0..HEADER {
            assert_eq!(specialized(&module[..words], |_| None), &module[..words]);
        }
        assert_eq!(specialized(&module[..HEADER], |_| None), &module[..HEADER]);
    }
}
