//! The shape of the house, read from its sources.

mod circles;
mod dependencies;
mod front_door;
mod graph;
mod layers;
mod source;
mod style;
