//! Which points bonds still hold together.

use crate::domain::PeridynamicDomain;

/// What must be left of a bond for it to hold two points together \[1\].
const HOLDS: f64 = 0.1;

/// Fewest points of a part: fewer do not resolve the crack that cut it off.
const FEWEST: usize = 8;

/// Length of bonds, in points' distances, over which loose points count as one heap, and points of
/// different parts as beside a crack.
const BESIDE: f64 = 1.6;

/// Not visited yet.
const OPEN: u32 = u32::MAX;

/// The parts of a body.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct BondedParts {
    /// The part of each point; `None` of what is loose and too little for a heap of its own.
    pub(super) of: Vec<Option<u32>>,
    /// Parts that bonds hold together; heaps of loose points are numbered from here on.
    pub(super) held: u32,
    /// All parts.
    pub(super) count: u32,
    /// Points that no bond holds to as many as make a part.
    pub(super) loose: Vec<bool>,
    /// Points beside a crack between two parts, and loose ones.
    pub(super) beside: Vec<bool>,
}

/// Neighbours of each point over some bonds.
struct NeighbourList {
    starts: Vec<usize>,
    ends: Vec<u32>,
}

impl NeighbourList {
    fn new(points: usize, of: impl Fn(usize) -> Vec<u32>) -> Self {
        let (mut starts, mut ends) = (vec![0], Vec::new());
        for p in 0..points {
            ends.extend(of(p));
            starts.push(ends.len());
        }
        Self { starts, ends }
    }

    fn of(&self, point: u32) -> &[u32] {
        &self.ends[self.starts[point as usize]..self.starts[point as usize + 1]]
    }

    fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Components that no single bond holds together, by their first points: what one bond joins to
    /// others falls off (Tarjan's bridges).
    fn bridgeless(&self) -> Vec<u32> {
        let n = self.len();
        let (mut number, mut low) = (vec![OPEN; n], vec![OPEN; n]);
        let mut part = vec![OPEN; n];
        let (mut next, mut parts) = (0, 0);
        let mut waiting: Vec<u32> = Vec::new();
        let mut path: Vec<(u32, u32, usize)> = Vec::new();
        for start in 0..n as u32 {
            if number[start as usize] != OPEN {
                continue;
            }
            path.push((start, OPEN, 0));
            while let Some(&mut (p, from, ref mut seen)) = path.last_mut() {
                if *seen == 0 {
                    (number[p as usize], low[p as usize]) = (next, next);
                    next += 1;
                    waiting.push(p);
                }
                if let Some(&q) = self.of(p).get(*seen) {
                    *seen += 1;
                    if q == from {
                        continue;
                    }
                    match number[q as usize] {
                        OPEN => path.push((q, p, 0)),
                        seen => low[p as usize] = low[p as usize].min(seen),
                    }
                    continue;
                }
                path.pop();
                if let Some(&(above, ..)) = path.last() {
                    low[above as usize] = low[above as usize].min(low[p as usize]);
                }
                if low[p as usize] == number[p as usize] {
                    while let Some(q) = waiting.pop() {
                        part[q as usize] = parts;
                        if q == p {
                            break;
                        }
                    }
                    parts += 1;
                }
            }
        }
        part
    }
}

/// How many points each number of a list has.
fn sizes(part: &[u32]) -> Vec<usize> {
    let count = part.iter().map(|&k| k as usize + 1).max().unwrap_or(0);
    let mut sizes = vec![0; count];
    part.iter().for_each(|&k| sizes[k as usize] += 1);
    sizes
}

impl BondedParts {
    /// Of a body as it is, its points `spacing` \[m\] apart.
    pub(super) fn of(domain: &PeridynamicDomain, spacing: f64) -> Self {
        let points = domain.places.len();
        let held = |p: usize| {
            let bonds = domain.bonds.of(p).filter(|bond| domain.left(*bond) > HOLDS);
            bonds.map(|bond| bond.end as u32).collect()
        };
        let part = NeighbourList::new(points, held).bridgeless();
        let size = sizes(&part);
        let loose: Vec<bool> = part.iter().map(|&k| size[k as usize] < FEWEST).collect();
        let near = |p: usize| {
            let bonds = domain.bonds.of(p);
            let bonds = bonds.filter(move |bond| domain.rest(p, *bond) < BESIDE * spacing);
            bonds.map(|bond| bond.end)
        };
        let beside_it = |p: usize| {
            let ends = near(p).filter(|&q| loose[p] && loose[q]);
            ends.map(|q| q as u32).collect()
        };
        let heap = NeighbourList::new(points, beside_it).heaps();
        let heaped = sizes(&heap);
        // Numbered by their first points, parts before heaps.
        let (mut names, mut of) = (vec![OPEN; size.len()], vec![None; points]);
        let mut count = 0;
        for p in (0..points).filter(|&p| !loose[p]) {
            of[p] = Some(name(&mut names[part[p] as usize], &mut count));
        }
        let held = count;
        let mut names = vec![OPEN; heaped.len()];
        for p in (0..points).filter(|&p| loose[p] && heaped[heap[p] as usize] >= FEWEST) {
            of[p] = Some(name(&mut names[heap[p] as usize], &mut count));
        }
        let other = |p: usize| near(p).any(|q| of[q] != of[p]);
        let beside = (0..points).map(|p| loose[p] || other(p)).collect();
        Self { of, held, count, loose, beside }
    }
}

/// The number of what may have none yet.
fn name(known: &mut u32, next: &mut u32) -> u32 {
    if *known == OPEN {
        *known = *next;
        *next += 1;
    }
    *known
}

impl NeighbourList {
    /// Components.
    fn heaps(&self) -> Vec<u32> {
        let mut part = vec![OPEN; self.len()];
        let (mut parts, mut stack) = (0, Vec::new());
        for start in 0..self.len() as u32 {
            if part[start as usize] != OPEN {
                continue;
            }
            part[start as usize] = parts;
            stack.push(start);
            while let Some(p) = stack.pop() {
                for &q in self.of(p) {
                    if part[q as usize] == OPEN {
                        part[q as usize] = parts;
                        stack.push(q);
                    }
                }
            }
            parts += 1;
        }
        part
    }
}

#[cfg(test)]
mod tests {
    use super::NeighbourList;

    fn list(points: usize, bonds: &[[usize; 2]]) -> NeighbourList {
        let other = |p: usize| {
            let mine = bonds.iter().filter(|bond| bond.contains(&p));
            mine.map(|[a, b]| if *a == p { *b as u32 } else { *a as u32 }).collect()
        };
        NeighbourList::new(points, other)
    }

    /// Two triangles that one bond joins are two, those that two join are one; what hangs by one
    /// bond falls off.
    #[test]
    fn what_one_bond_joins_falls_apart() {
        let triangles = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]];
        let with = |more: &[[usize; 2]]| {
            let all: Vec<[usize; 2]> = triangles.iter().chain(more).copied().collect();
            let part = list(7, &all).bridgeless();
            (part[0] == part[3], part[0] == part[6], part[0] == part[1])
        };
        assert_eq!(with(&[]), (false, false, true));
        assert_eq!(with(&[[2, 3]]), (false, false, true));
        assert_eq!(with(&[[2, 3], [0, 6]]), (false, false, true));
        assert_eq!(with(&[[2, 3], [1, 4]]), (true, false, true));
        assert_eq!(with(&[[2, 3], [0, 6], [6, 5]]), (true, true, true));
        let heap = list(7, &triangles).heaps();
        assert!(heap[0] == heap[2] && heap[3] == heap[5] && heap[0] != heap[3]);
    }
}
