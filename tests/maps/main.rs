//! Files in and out, and what bad ones get.

mod bad_input;
mod images;
