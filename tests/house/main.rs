//! The shape of the house, read from its sources.

mod front_door;
mod layers;
