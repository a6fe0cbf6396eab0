//! A slow twin: every node's points flooded one by one, on a body that shatters at random.

use super::{AROUND, BackgroundGrid, split};
use crate::mpm::bonds::Bonds;
use crate::mpm::stencil::Stencil;
use crate::particles::Particles;
use cullet_geometry::{Vec3, math::unit};

/// The nodes that each point sees, by id.
fn seen(grid: &BackgroundGrid, particles: &Particles) -> Vec<[u32; AROUND]> {
    let mut seen = vec![[0; AROUND]; particles.len()];
    for element in &grid.elements {
        for p in element.points() {
            seen[particles.id[p] as usize] = element.nodes;
        }
    }
    seen
}

/// Points of a node, by id in the order of the arrays, with the node's number at each.
fn points(node: u32, grid: &BackgroundGrid, particles: &Particles) -> Vec<(u32, usize)> {
    let numbers = grid.elements.iter().filter_map(|element| {
        Some((element, element.nodes.iter().position(|&other| other == node)?))
    });
    numbers
        .flat_map(|(element, k)| particles.id[element.points()].iter().map(move |&id| (id, k)))
        .collect()
}

/// The set of each of a node's points.
fn sets(bonds: &Bonds, points: &[(u32, usize)]) -> Vec<Option<usize>> {
    let at = |id: u32| points.iter().position(|&(other, _)| other == id);
    let mut sets = vec![None; points.len()];
    let mut count = 0;
    for start in 0..points.len() {
        if sets[start].is_some() || !bonds.is_whole(points[start].0) {
            continue;
        }
        let mut stack = vec![start];
        while let Some(here) = stack.pop() {
            sets[here] = Some(count);
            let near = bonds.joined(points[here].0).filter_map(at);
            stack.extend(near.filter(|&other| sets[other].is_none()));
        }
        count += 1;
    }
    while count > 0 && sets.contains(&None) {
        let before = sets.clone();
        for here in (0..points.len()).filter(|&here| before[here].is_none()) {
            let mut votes = vec![0; count];
            for (other, weight) in bonds.votes(points[here].0) {
                if let Some(set) = at(other).and_then(|other| before[other]) {
                    votes[set] += weight;
                }
            }
            let most = votes.iter().max().copied().unwrap_or(0);
            sets[here] = votes.iter().position(|&votes| votes == most && most > 0);
        }
        if before == sets {
            sets.iter_mut().for_each(|set| *set = set.or(Some(0)));
        }
    }
    sets
}

/// How many nodes have parted: each as its sets say, and all that had a bond cut and needed to.
fn check([old, bonds]: [&Bonds; 2], [before, after]: [(&BackgroundGrid, &Particles); 2]) -> usize {
    let (was, is) = (seen(before.0, before.1), seen(after.0, after.1));
    let mut parted = 0;
    for node in 0..before.0.nodes.len() as u32 {
        let points = points(node, before.0, before.1);
        let now = |at: usize| is[points[at].0 as usize][points[at].1];
        assert!(points.iter().all(|&(id, k)| was[id as usize][k] == node));
        let sets = sets(bonds, &points);
        if (0..points.len()).all(|at| now(at) == node) {
            let is_cut = |id: u32| !old.votes(id).eq(bonds.votes(id));
            let is_one = sets.iter().all(|&set| set == sets[0]);
            assert!(is_one || !points.iter().any(|&(id, _)| is_cut(id)), "node {node} is one");
            continue;
        }
        for a in 0..points.len() {
            for b in 0..a {
                assert_eq!(sets[a] == sets[b], now(a) == now(b), "node {node}, {a} and {b}");
            }
        }
        parted += 1;
    }
    parted
}

/// Whether what the nodes weigh is what their points give them.
fn weigh(grid: &BackgroundGrid, particles: &Particles) {
    let mut mass = vec![0.0; grid.nodes.len()];
    for element in &grid.elements {
        for p in element.points() {
            Stencil::new(&particles.reference[p], &grid.spacing).visit(|k, weight, _| {
                mass[element.nodes[k] as usize] += weight * particles.mass(p);
            });
        }
    }
    for (n, (a, b)) in mass.iter().zip(&grid.nodes.mass).enumerate() {
        assert!((a - b).abs() < 1e-12, "node {n} weighs {b}, its points {a}");
    }
}

#[test]
fn nodes_part_as_their_points_are_connected_one_by_one() {
    let places: Vec<Vec3> =
        (0..1500).map(|i| Vec3::from([0, 1, 2].map(|a| 5.5 * unit(4, a, i)))).collect();
    let mut particles = Particles::at_rest(&places, 166.0, 1.0);
    let spacing = Vec3::repeat(1.0);
    let mut grid = BackgroundGrid::new(&mut particles, spacing);
    let mut bonds = Bonds::new(&particles, &spacing);
    let (mut slots, mut parted) = (vec![0; places.len()], 0);
    for round in 0..6 {
        for (p, &id) in particles.id.iter().enumerate() {
            slots[id as usize] = p as u32;
        }
        // Sheets, and crumbs.
        let chance = |id: u32| unit(7 + round, 0, u64::from(id));
        let near = |x: &Vec3| (x.x + x.y - 2.0 - round as f64).abs() < 0.4;
        let breaks = |id: u32| chance(id) < if near(&places[id as usize]) { 0.8 } else { 0.06 };
        let whole = (0..places.len() as u32).filter(|&id| bonds.is_whole(id));
        let broken: Vec<u32> = whole.filter(|&id| breaks(id)).collect();
        for &id in &broken {
            let p = slots[id as usize] as usize;
            let tilt = Vec3::from([0, 1, 2].map(|a| unit(11, a, u64::from(id)) - 0.5));
            particles.damage[p] = 1.0;
            particles.normal[p] = (Vec3::new(1.0, 1.0, 0.0) + tilt).normalize();
        }
        let (old, before) = (bonds.clone(), (grid.clone(), particles.clone()));
        // Those of near points are another test's.
        let nodes: Vec<(u32, bool)> = bonds
            .grow(&broken, &grid, &particles, &slots)
            .into_iter()
            .map(|(node, _)| (node, false))
            .collect();
        split(&bonds, &nodes, &mut grid, &mut particles, &slots);
        let states = [(&before.0, &before.1), (&grid, &particles)];
        parted += check([&old, &bonds], states);
        weigh(&grid, &particles);
    }
    assert!(parted > 500, "{parted} nodes parted");
    assert!(grid.nodes.len() > 1500, "{} nodes", grid.nodes.len());
}

/// A flat crack through half of a block, to x = 5: which nodes in its plane part by what they see
/// within a cell, and which by all that they see.
#[test]
fn a_node_parts_where_its_near_points_are_apart() {
    let place = |i: u64| {
        let cell = Vec3::new((i / 400) as f64, (i / 20 % 20) as f64, (i % 20) as f64);
        cell * 0.5 + Vec3::from([0, 1, 2].map(|a| 0.1 + 0.3 * unit(5, a, i)))
    };
    let places: Vec<Vec3> = (0..8000).map(place).collect();
    let spacing = Vec3::repeat(1.0);
    let parted = |by_near: bool| {
        let mut particles = Particles::at_rest(&places, 1000.0, 1.0);
        let mut grid = BackgroundGrid::new(&mut particles, spacing);
        let mut bonds = Bonds::new(&particles, &spacing);
        let cut = |a: &Vec3, b: &Vec3| {
            let across = a.y < 5.0 && b.y >= 5.0;
            across && (a + (b - a) * ((5.0 - a.y) / (b.y - a.y))).x < 5.0
        };
        let mut slots = vec![0; places.len()];
        for (p, &id) in particles.id.iter().enumerate() {
            slots[id as usize] = p as u32;
        }
        bonds.sever(cut, &particles, &slots);
        let nodes: Vec<(u32, bool)> =
            (0..grid.nodes.len() as u32).map(|node| (node, by_near)).collect();
        let before = grid.nodes.len();
        split(&bonds, &nodes, &mut grid, &mut particles, &slots);
        weigh(&grid, &particles);
        let mut found: Vec<[i32; 3]> = (before..grid.nodes.len())
            .map(|copy| grid.nodes.place[grid.nodes.origin[copy] as usize])
            .collect();
        found.sort_unstable();
        found
    };
    let inner = |x: i32| (3..8).map(move |z| [x, 5, z]);
    let (by_near, by_all) = (parted(true), parted(false));
    let share = |found: &[[i32; 3]], x| inner(x).filter(|at| found.contains(at)).count();
    assert_eq!([share(&by_near, 3), share(&by_all, 3)], [5, 5]);
    assert_eq!([share(&by_near, 4), share(&by_all, 4)], [5, 0]);
    assert_eq!([share(&by_near, 5), share(&by_all, 5)], [0, 0]);
    assert!(by_all.iter().all(|at| by_near.contains(at)), "near points part more, never less");
}
