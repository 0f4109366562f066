//! Tests of glTF models: the contents of third-party files, the refusal of hostile files, and posed vertices.

mod build;
mod claims;
mod contents;
mod creatures;
mod damaged;
mod extensions;
mod files;
mod hostile;
mod poses;
mod samples;
mod validator;

use leadr_testing::memory::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
