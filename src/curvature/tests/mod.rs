//! The room as a whole: shapes whose answer is known, laws, files.

mod files;
mod laws;
mod meshes;
mod shapes;
mod solids;
mod vertices;
