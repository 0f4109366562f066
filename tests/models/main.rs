//! glTF models: what the files of others hold, what hostile ones get, and where posed vertices are.

#[path = "../common/mod.rs"]
mod common;

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

use common::memory::Counting;

#[global_allocator]
static ALLOCATOR: Counting = Counting;
