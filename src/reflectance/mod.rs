//! reflectance
