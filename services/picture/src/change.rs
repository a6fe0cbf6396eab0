//! What differs between two moments, in tiles: what does not differ need not be shaded again.

use super::raster::Buffers;

/// Side of a tile \[pixels\].
const TILE: usize = 8;

/// The tiles in which two pictures of one size differ.
pub(super) struct ChangedTiles {
    across: usize,
    down: usize,
    tiles: Vec<bool>,
}

impl ChangedTiles {
    /// Compares all that is seen; a number that is none counts as a difference.
    pub(super) fn between(old: &Buffers, new: &Buffers) -> Self {
        let (across, down) = (new.width.div_ceil(TILE), new.height.div_ceil(TILE));
        let mut tiles = vec![false; across * down];
        for y in 0..new.height {
            let line = y * new.width..(y + 1) * new.width;
            let row = &mut tiles[y / TILE * across..][..across];
            mark(row, &old.near[line.clone()], &new.near[line.clone()]);
            if !new.who.is_empty() {
                mark(row, &old.who[line.clone()], &new.who[line.clone()]);
                mark(row, &old.normal[line.clone()], &new.normal[line.clone()]);
            }
            if !new.tint.is_empty() {
                mark(row, &old.tint[line.clone()], &new.tint[line]);
            }
        }
        Self { across, down, tiles }
    }

    /// With all tiles that lie within so many pixels of a changed one.
    pub(super) fn spread(self, pixels: usize) -> Self {
        let reach = pixels.div_ceil(TILE);
        let (across, down) = (self.across, self.down);
        self.along(1, across, reach).along(across, down, reach)
    }

    /// Spreads along lines of `length` tiles whose neighbours lie `stride` apart.
    fn along(self, stride: usize, length: usize, reach: usize) -> Self {
        let mut tiles = vec![false; self.tiles.len()];
        for (index, _) in self.tiles.iter().enumerate().filter(|(_, changed)| **changed) {
            let at = index / stride % length;
            let line = index - at * stride;
            for near in at.saturating_sub(reach)..(at + reach + 1).min(length) {
                tiles[line + near * stride] = true;
            }
        }
        Self { tiles, ..self }
    }

    /// The number of the tile that holds a pixel.
    pub(super) fn tile(width: usize, x: usize, y: usize) -> usize {
        y / TILE * width.div_ceil(TILE) + x / TILE
    }

    /// Whether that tile changed.
    pub(super) fn touched(&self, tile: usize) -> bool {
        self.tiles[tile]
    }
}

/// Marks the tiles of a row in which two lines differ.
fn mark<T: PartialEq>(row: &mut [bool], old: &[T], new: &[T]) {
    for ((changed, old), new) in row.iter_mut().zip(old.chunks(TILE)).zip(new.chunks(TILE)) {
        // Without a way out early this is a few wide comparisons.
        *changed |= old.iter().zip(new).fold(false, |differs, (a, b)| differs | (a != b));
    }
}
