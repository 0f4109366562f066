mod mesh;
mod reference;
mod waves;
