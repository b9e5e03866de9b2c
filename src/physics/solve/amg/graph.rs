//! Which nodes of a level belong together.

use crate::physics::assembly::BlockPattern;

/// The neighbours of each node of a level, without itself, ascending.
#[derive(Clone, Debug)]
pub(super) struct Graph {
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Graph {
    /// Rows that the pattern has as neighbours.
    pub fn of_pattern(pattern: &BlockPattern) -> Self {
        let mut rows: Vec<Vec<u32>> = (0..pattern.row_count()).map(|row| pattern.near(row).collect()).collect();
        for row in 0..pattern.row_count() {
            for column in pattern.near(row) {
                rows[column as usize].push(row as u32);
            }
        }
        Self::of_rows(rows)
    }

    /// The neighbours of each node, sorted and each once.
    fn of_rows(rows: Vec<Vec<u32>>) -> Self {
        let mut graph = Self { starts: vec![0], neighbours: Vec::new() };
        for mut row in rows {
            row.sort_unstable();
            row.dedup();
            graph.neighbours.extend(row);
            graph.starts.push(graph.neighbours.len() as u32);
        }
        graph
    }

    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub fn neighbours(&self, node: usize) -> &[u32] {
        &self.neighbours[self.starts[node] as usize..self.starts[node + 1] as usize]
    }

    /// The graph of groups of nodes: groups are neighbours where two of their nodes are.
    pub fn quotient(&self, group_of: &[u32], groups: usize) -> Self {
        let mut rows = vec![Vec::new(); groups];
        for (node, &group) in group_of.iter().enumerate() {
            let others = self.neighbours(node).iter().map(|&other| group_of[other as usize]);
            rows[group as usize].extend(others.filter(|&other| other != group));
        }
        Self::of_rows(rows)
    }

    /// The nodes from one neighbour to the next, breadth first.
    fn breadth_first(&self) -> Vec<u32> {
        let mut seen = vec![false; self.len()];
        let mut order = Vec::with_capacity(self.len());
        for start in 0..self.len() as u32 {
            let mut next = order.len();
            if !core::mem::replace(&mut seen[start as usize], true) {
                order.push(start);
            }
            while let Some(&node) = order.get(next) {
                for &neighbour in self.neighbours(node as usize) {
                    if !core::mem::replace(&mut seen[neighbour as usize], true) {
                        order.push(neighbour);
                    }
                }
                next += 1;
            }
        }
        order
    }

    /// Puts each node into an aggregate: number by node, and how many there are. Greedily: first whole neighbourhoods
    /// of which no node is taken, then what is left over joins a neighbour (Vaněk, Mandel & Brezina 1996, algorithm
    /// 5.1).
    pub fn aggregates(&self) -> (Vec<u32>, usize) {
        const FREE: u32 = u32::MAX;
        let mut aggregate_of = vec![FREE; self.len()];
        let mut count = 0;
        for node in self.breadth_first() {
            let neighbours = self.neighbours(node as usize);
            let free = |&n: &u32| aggregate_of[n as usize] == FREE;
            if free(&node) && neighbours.iter().all(free) {
                aggregate_of[node as usize] = count;
                for &neighbour in neighbours {
                    aggregate_of[neighbour as usize] = count;
                }
                count += 1;
            }
        }
        let whole = aggregate_of.clone();
        for (node, aggregate) in aggregate_of.iter_mut().enumerate() {
            if *aggregate == FREE {
                *aggregate = self.most_frequent(node, &whole, FREE).unwrap_or(FREE);
            }
        }
        for node in 0..self.len() {
            if aggregate_of[node] == FREE {
                aggregate_of[node] = count;
                for &neighbour in self.neighbours(node) {
                    if aggregate_of[neighbour as usize] == FREE {
                        aggregate_of[neighbour as usize] = count;
                    }
                }
                count += 1;
            }
        }
        (aggregate_of, count as usize)
    }

    /// The label most neighbours have, other than `none`; of several the smallest.
    fn most_frequent(&self, node: usize, labels: &[u32], none: u32) -> Option<u32> {
        let neighbours = self.neighbours(node);
        let label = |&n: &u32| labels[n as usize];
        let count = |l: u32| neighbours.iter().filter(|n| label(n) == l).count();
        neighbours.iter().map(label).filter(|&l| l != none).max_by_key(|&l| (count(l), core::cmp::Reverse(l)))
    }
}
