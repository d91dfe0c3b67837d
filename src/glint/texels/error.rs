//! What a normal map can lack.

use std::fmt;

/// Why there are no glints of a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InvalidTexels {
    /// The map has no texels, or not three channels: rows, columns, channels.
    Shape(usize, usize, usize),
    /// The widths are of another size than the normals: (rows, columns) of the widths and of the normals.
    AlphaSize((usize, usize), (usize, usize)),
    /// A level is of another shape than the map's size makes it: its number, its channels, rows and columns, and those it
    /// should have.
    LevelShape(usize, [usize; 3], [usize; 3]),
    /// Coarse levels are missing, or there are more than the size makes: levels, and those there should be.
    LevelCount(usize, usize),
    /// A level holds what is no finite number.
    NotFinite(usize),
    /// A block cannot be of any slopes: its level, row and column, and what is wrong.
    Block(usize, [usize; 2], &'static str),
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
            Self::LevelShape(k, [a, b, c], [channels, rows, columns]) => {
                write!(f, "level {k} is {a} channels of {b} x {c}, not {channels} of {rows} x {columns}")
            }
            Self::LevelCount(levels, count) => write!(f, "{levels} levels where the size makes {count}"),
            Self::NotFinite(k) => write!(f, "level {k} holds a value that is not finite"),
            Self::Block(k, [row, column], what) => write!(f, "level {k}, row {row}, column {column}: {what}"),
        }
    }
}

impl std::error::Error for InvalidTexels {}
