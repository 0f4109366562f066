//! glTF models: what the files of others hold, what hostile ones get, and where posed vertices are.

#[path = "../common/mod.rs"]
mod common;

mod samples;
mod validator;
