//! glTF models: what the files of others hold, what hostile ones get, and where posed vertices are.

mod build;
mod claims;
mod contents;
mod creatures;
mod damaged;
mod files;
mod hostile;
mod poses;
mod samples;
mod validator;

use leadr_testing::memory::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
