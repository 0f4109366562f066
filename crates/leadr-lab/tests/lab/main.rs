//! Tests of quadrature rules, ray casts, shadowing, and the forward pass of the bench.

mod classes;
mod forward;
mod normal_forms;
mod quadrature;
mod ray_cast;
mod shadowing;
