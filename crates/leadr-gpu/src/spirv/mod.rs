//! Changes SPIR-V before it reaches the driver. Opcodes and other numbers come from the SPIR-V 1.6 specification.

mod fold;
mod loops;
mod specialize;

pub(super) use loops::leave_loops_to_driver;
pub(super) use specialize::specialized;

use leadr_glsl::spirv::{HEADER, Instruction, all_instructions, instructions};

/// The index of the header word that holds the upper bound of all identifiers.
const BOUND: usize = 3;
const OP_LOOP_MERGE: u32 = 246;
