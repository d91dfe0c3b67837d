//! What a normal map can lack.

use std::fmt;

/// Why there are no glints of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InvalidTexels {
    /// The map has no texels, or not three channels: rows, columns, channels.
    Shape(usize, usize, usize),
    /// The widths are of another size than the normals: (rows, columns) of the widths and of the normals.
    AlphaSize((usize, usize), (usize, usize)),
}

impl fmt::Display for InvalidTexels {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Shape(rows, columns, channels) => {
                write!(f, "normals need rows, columns and 3 channels, not {rows} x {columns} x {channels}")
            }
            Self::AlphaSize((r, c), (rows, columns)) => {
                write!(f, "widths of {r} rows and {c} columns do not fit normals of {rows} rows and {columns} columns")
            }
        }
    }
}

impl std::error::Error for InvalidTexels {}
