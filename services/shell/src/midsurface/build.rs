//! Midsurfaces from patches.

use super::{CellTable, Midsurface, StepBounds, SurfaceCell, TablePoint};
use cullet_geometry::nurbs::{KnotSpan, NurbsPatch, PatchBasis};
use std::collections::BTreeMap;

/// Gauss points in a direction and their weights on [0, 1]: two points a direction do not lock
/// (F86), three are the full rule that the tests compare with.
pub(super) fn gauss(rule: usize) -> Vec<(f64, f64)> {
    match rule {
        3 => {
            let a = 0.5 * 0.6_f64.sqrt();
            vec![(0.5 - a, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.5 + a, 5.0 / 18.0)]
        }
        _ => {
            let a = 0.5 / 3.0_f64.sqrt();
            vec![(0.5 - a, 0.5), (0.5 + a, 0.5)]
        }
    }
}

/// Tables by the bits of what is in them.
#[derive(Default)]
struct Tables {
    list: Vec<CellTable>,
    places: BTreeMap<Vec<u64>, u32>,
}

impl Tables {
    fn keep(&mut self, table: CellTable) -> u32 {
        let numbers = |p: &TablePoint| {
            let rows = p.derivatives.iter().flatten().copied();
            rows.chain(p.value).chain([p.weight]).map(f64::to_bits).collect::<Vec<_>>()
        };
        let key = table.points.iter().flat_map(numbers).chain(table.extent.map(f64::to_bits));
        let next = self.list.len() as u32;
        let place = *self.places.entry(key.collect()).or_insert(next);
        if place == next {
            self.list.push(table);
        }
        place
    }
}

impl Midsurface {
    /// A patch, with two Gauss points a direction in each cell.
    #[must_use]
    pub fn of_patch(patch: &NurbsPatch) -> Self {
        Self::with_rule(patch, 2)
    }

    /// A patch with that many Gauss points a direction in each cell, two or three.
    #[must_use]
    pub fn with_rule(patch: &NurbsPatch, rule: usize) -> Self {
        let spans = [0, 1].map(|axis| patch.axes()[axis].spans());
        let (rule, mut tables, mut cells) = (gauss(rule), Tables::default(), Vec::new());
        let mut functions = 0;
        for v in &spans[1] {
            for u in &spans[0] {
                let (table, basis) = cell_table(patch, [u, v], &rule);
                functions = basis.count;
                cells.push(SurfaceCell { nodes: basis.nodes, table: tables.keep(table) });
            }
        }
        let rings = [0, 1].map(|axis| patch.axes()[axis].is_ring());
        let count = [0, 1].map(|axis| spans[axis].len() * rule.len());
        let (starts, neighbours) = lattice_links(count, rings, rule.len());
        let nodes = patch.points().to_vec();
        let share = vec![1.0; starts.len() - 1];
        Self {
            nodes,
            functions,
            cells,
            tables: tables.list,
            starts,
            neighbours,
            share,
            missing: Vec::new(),
            steps: StepBounds::PATCH,
            faces: Vec::new(),
        }
    }
}

fn cell_table(
    patch: &NurbsPatch,
    [u, v]: [&KnotSpan; 2],
    rule: &[(f64, f64)],
) -> (CellTable, PatchBasis) {
    let mut points = Vec::new();
    let area = u.length * v.length;
    let mut any = patch.evaluate([u, v], [0.5, 0.5]);
    for &(y, wy) in rule {
        for &(x, wx) in rule {
            any = patch.evaluate([u, v], [x, y]);
            points.push(TablePoint::new(wx * wy * area, &any));
        }
    }
    (CellTable { extent: [u.length, v.length], points, corners: Vec::new() }, any)
}

/// Links of a lattice of points to their up to eight neighbours. Points are counted cell by cell.
fn lattice_links(count: [usize; 2], ring: [bool; 2], rule: usize) -> (Vec<u32>, Vec<u32>) {
    let cells = count[0] / rule;
    let number = |i: usize, j: usize| {
        let cell = (j / rule) * cells + i / rule;
        (cell * rule * rule + (j % rule) * rule + i % rule) as u32
    };
    let beside = |k: usize, axis: usize| -> Vec<usize> {
        let n = count[axis];
        let moved = [k.checked_sub(1).or(ring[axis].then_some(n - 1)), Some(k), Some(k + 1)];
        let inside = |k: usize| (k < n).then_some(k).or(ring[axis].then_some(0));
        moved.into_iter().flatten().filter_map(inside).collect()
    };
    let mut around = vec![Vec::new(); count[0] * count[1]];
    for j in 0..count[1] {
        for i in 0..count[0] {
            let own = &mut around[number(i, j) as usize];
            for &y in &beside(j, 1) {
                own.extend(
                    beside(i, 0).iter().filter(|&&x| (x, y) != (i, j)).map(|&x| number(x, y)),
                );
            }
            own.sort_unstable();
            own.dedup();
        }
    }
    let mut starts = vec![0];
    let mut neighbours = Vec::new();
    for own in around {
        neighbours.extend(own);
        starts.push(neighbours.len() as u32);
    }
    (starts, neighbours)
}
