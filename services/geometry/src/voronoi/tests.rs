use super::{Cells, Face, Key, VoronoiError, WALL};
use crate::math::{Vec3, unit};
use std::collections::BTreeMap;

fn random_sites(n: u64, seed: u64) -> Vec<Vec3> {
    let at = |i, k| 0.001 + 0.998 * unit(seed, k, i);
    (0..n).map(|i| Vec3::new(at(i, 0), 2.0 * at(i, 1), 0.5 * at(i, 2))).collect()
}

fn box_of(sites: Vec<Vec3>) -> Cells {
    Cells::new(sites, Vec3::zeros(), Vec3::new(1.0, 2.0, 0.5)).unwrap()
}

/// n³ lattice sites of spacing 1/n in the unit cube, moved by at most `jitter` of it.
fn lattice(n: u64, jitter: f64) -> Cells {
    let h = 1.0 / n as f64;
    let sites = (0..n * n * n).map(|i| {
        let node = [i % n, i / n % n, i / (n * n)];
        let at =
            |k: usize| (node[k] as f64 + 0.5 + jitter * (2.0 * unit(3, k as u64, i) - 1.0)) * h;
        Vec3::new(at(0), at(1), at(2))
    });
    Cells::new(sites.collect(), Vec3::zeros(), Vec3::repeat(1.0)).unwrap()
}

fn diagram(cells: &Cells) -> Vec<Vec<Face>> {
    (0..cells.sites().len() as u32).map(|i| cells.cell(i).unwrap()).collect()
}

fn volume(cells: &Cells, faces: &[Face]) -> f64 {
    let mut six = 0.0;
    for face in faces {
        let p: Vec<Vec3> = face.corners.iter().map(|key| cells.position(key)).collect();
        for k in 2..p.len() {
            six += p[0].dot(&p[k - 1].cross(&p[k]));
        }
    }
    six / 6.0
}

/// Rotates a loop so that it starts at its least key.
fn canonical(mut corners: Vec<Key>) -> Vec<Key> {
    let least = (0..corners.len()).min_by_key(|&k| corners[k]).unwrap();
    corners.rotate_left(least);
    corners
}

fn assert_is_partition(cells: &Cells, whole: f64) {
    let diagram = diagram(cells);
    let sum: f64 = diagram.iter().map(|faces| volume(cells, faces)).sum();
    assert!((sum - whole).abs() < 1e-12 * whole, "cells sum to {sum}, the box is {whole}");
    let mut sides: BTreeMap<(u32, u32), Vec<Key>> = BTreeMap::new();
    for (i, faces) in diagram.iter().enumerate() {
        for face in faces {
            sides.insert((i as u32, face.neighbour), canonical(face.corners.clone()));
        }
    }
    for (&(i, j), corners) in &sides {
        if j < WALL {
            let mut other = sides[&(j, i)].clone();
            other.reverse();
            assert_eq!(&canonical(other), corners, "faces {i} {j}");
        }
    }
}

#[test]
fn cells_fill_the_box_and_neighbours_share_their_corners() {
    for n in [1, 2, 5, 40, 3000] {
        assert_is_partition(&box_of(random_sites(n, n)), 1.0);
    }
    for jitter in [1e-2, 1e-4, 1e-7, 1e-13] {
        assert_is_partition(&lattice(9, jitter), 1.0);
    }
}

#[test]
fn every_point_lies_in_the_cell_of_its_nearest_site() {
    let cells = box_of(random_sites(300, 11));
    let diagram = diagram(&cells);
    for (n, &p) in random_sites(2000, 99).iter().enumerate() {
        let square = |i: u32| (cells.sites()[i as usize] - p).norm_squared();
        let naive = (0..300).min_by(|&a, &b| square(a).total_cmp(&square(b))).unwrap();
        assert_eq!(cells.nearest(p), naive, "point {n}");
        let odd = (0..300).filter(|i| i % 2 == 1);
        let naive_odd = odd.min_by(|&a, &b| square(a).total_cmp(&square(b)));
        assert_eq!(cells.nearest_of(p, |i| i % 2 == 1), naive_odd);
        for face in &diagram[naive as usize] {
            let c: Vec<Vec3> = face.corners.iter().map(|key| cells.position(key)).collect();
            let normal = newell(&c);
            assert!((p - c[0]).dot(&normal) <= 1e-12 * normal.norm(), "point {n} is outside");
        }
    }
}

/// Twice the area vector of a polygon.
fn newell(corners: &[Vec3]) -> Vec3 {
    let n = corners.len();
    (0..n).map(|k| (corners[k] - corners[0]).cross(&(corners[(k + 1) % n] - corners[0]))).sum()
}

#[test]
fn three_cells_meet_at_every_edge() {
    let cells = lattice(6, 1e-3);
    let mut edges: BTreeMap<(Key, Key), u32> = BTreeMap::new();
    for face in diagram(&cells).iter().flatten() {
        for k in 0..face.corners.len() {
            let (a, b) = (face.corners[k], face.corners[(k + 1) % face.corners.len()]);
            *edges.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    for ((a, b), faces) in edges {
        let shared: Vec<u32> = a.iter().copied().filter(|id| b.contains(id)).collect();
        assert_eq!(shared.len(), 3, "{a:?} {b:?}");
        // Each of the cells (not walls) around an edge has two faces at it.
        let sites = shared.iter().filter(|&&id| id < WALL).count() as u32;
        assert_eq!(faces, 2 * sites);
    }
}

#[test]
fn special_position_and_bad_input_are_refused() {
    let unit_box = |sites| Cells::new(sites, Vec3::zeros(), Vec3::repeat(1.0));
    assert!(matches!(unit_box(vec![]), Err(VoronoiError::Count { count: 0 })));
    let out = unit_box(vec![Vec3::repeat(0.5), Vec3::new(0.5, 1.0, 0.5)]);
    assert_eq!(out.unwrap_err(), VoronoiError::Outside { site: 1 });
    let nan = unit_box(vec![Vec3::new(0.5, f64::NAN, 0.5)]);
    assert_eq!(nan.unwrap_err(), VoronoiError::Outside { site: 0 });
    let flat = Cells::new(vec![], Vec3::zeros(), Vec3::new(1.0, 0.0, 1.0));
    assert!(matches!(flat, Err(VoronoiError::Box { axis: 1, .. })));
    let twins = unit_box(vec![Vec3::repeat(0.5); 2]).unwrap();
    assert_eq!(twins.cell(0).unwrap_err(), VoronoiError::Degenerate { site: 0 });
    let exact = lattice(4, 0.0);
    assert!((0..64).any(|i| matches!(exact.cell(i), Err(VoronoiError::Degenerate { .. }))));
}

#[test]
fn ghosts_do_not_change_cells_they_cannot_reach() {
    // A tight cluster in a large box: the security radius must find the lone far site.
    let mut sites = random_sites(200, 5);
    for p in &mut sites {
        *p = Vec3::repeat(0.2) + 0.05 * *p;
    }
    sites.push(Vec3::new(0.9, 1.9, 0.45));
    assert_is_partition(&box_of(sites), 1.0);
}
