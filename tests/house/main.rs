//! The shape of the house, read from its sources.

mod layers;
