//! Cells in an order that keeps neighbours together and cells of one table in one tile.

use crate::kernel::CellSide;
use crate::midsurface::Midsurface;
use cullet_simd::LANES;

/// Elements in whole tiles, and the cell of each; `u32::MAX` where there is none.
pub(super) struct Arranged<const N: usize> {
    pub(super) elements: Vec<CellSide<N>>,
    pub(super) cells: Vec<u32>,
}

/// Places of a cell along each axis that the order can tell.
const PLACES: f64 = 1023.0;

pub(super) fn arrange<const N: usize>(surface: &Midsurface) -> Arranged<N> {
    let each = surface.points_per_cell();
    let live = |cell: usize| {
        let is_on = |q: &usize| surface.share[cell * each + q] > 0.0;
        (0..each).filter(is_on).fold(0u16, |bits, q| bits | 1 << q)
    };
    let middle = |cell: usize| surface.nodes[surface.cells[cell].nodes[N / 2] as usize];
    let cells = 0..surface.cells.len();
    let (mut low, mut high) = (middle(0), middle(0));
    for cell in cells.clone() {
        (low, high) = (low.inf(&middle(cell)), high.sup(&middle(cell)));
    }
    let size = (high - low).max().max(f64::MIN_POSITIVE);
    let code = |cell: usize| {
        let at = (middle(cell) - low) * (PLACES / size);
        (0..3).fold(0u64, |sum, axis| sum | spread(at[axis] as u64) << axis)
    };
    let on = cells.filter(|&cell| live(cell) != 0);
    let mut order: Vec<(u32, u64, u32)> =
        on.map(|cell| (surface.cells[cell].table, code(cell), cell as u32)).collect();
    order.sort_unstable();
    let (mut elements, mut own) = (Vec::new(), Vec::new());
    for group in order.chunk_by(|a, b| a.0 == b.0) {
        for &(table, _, cell) in group {
            let nodes = std::array::from_fn(|k| surface.cells[cell as usize].nodes[k]);
            elements.push(CellSide { nodes, table, live: live(cell as usize) });
            own.push(cell);
        }
        while elements.len() % LANES != 0 {
            elements.push(CellSide::vacant(group[0].0));
            own.push(u32::MAX);
        }
    }
    Arranged { elements, cells: own }
}

/// Bits of a number of up to 10, three apart.
fn spread(x: u64) -> u64 {
    (0..10).fold(0, |sum, bit| sum | (x >> bit & 1) << (3 * bit))
}
