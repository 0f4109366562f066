mod brdf;
mod shading;
mod slopes;
mod visible;
