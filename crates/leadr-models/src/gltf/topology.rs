//! Converts lists, strips and fans to triangles, and duplicates vertices for flat shading.

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    Points,
    Lines,
    Triangles,
    Strip,
    Fan,
}

impl Mode {
    pub(super) fn of_code(code: u64) -> Option<Self> {
        Some(match code {
            0 => Self::Points,
            1..=3 => Self::Lines,
            4 => Self::Triangles,
            5 => Self::Strip,
            6 => Self::Fan,
            _ => return None,
        })
    }

    /// Returns the number of triangles that `indices` indices form, and the number of unused indices.
    pub(super) const fn triangles(self, indices: usize) -> (usize, usize) {
        match self {
            Self::Points | Self::Lines => (0, 0),
            Self::Triangles => (indices / 3, indices % 3),
            Self::Strip | Self::Fan if indices < 3 => (0, indices),
            Self::Strip | Self::Fan => (indices - 2, 0),
        }
    }

    /// Returns the triangles with consistent winding. `index(i)` returns the i-th of `count` indices.
    pub(super) fn wind(self, count: usize, index: impl Fn(usize) -> u32) -> Vec<[u32; 3]> {
        let triangles = 0..self.triangles(count).0;
        let triangle = |i: usize| match self {
            // Every second triangle of a strip has the reverse order of vertices.
            Self::Strip => [i, i + 1 + i % 2, i + 2 - i % 2],
            Self::Fan => [i + 1, i + 2, 0],
            Self::Points | Self::Lines | Self::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
        };
        triangles.map(|i| triangle(i).map(&index)).collect()
    }
}

/// Copies the value of a vertex to each triangle corner that uses the vertex.
pub(super) fn per_corner<T: Copy>(values: &[T], triangles: &[[u32; 3]]) -> Vec<T> {
    triangles.as_flattened().iter().map(|&v| values[v as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_mode_by_the_tables_of_the_specification() {
        let wound = |mode: Mode, count| mode.wind(count, |i| i as u32);
        assert_eq!(wound(Mode::Triangles, 7), [[0, 1, 2], [3, 4, 5]]);
        assert_eq!(wound(Mode::Strip, 5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(wound(Mode::Fan, 5), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        for mode in [Mode::Triangles, Mode::Strip, Mode::Fan, Mode::Points, Mode::Lines] {
            assert!(wound(mode, 2).is_empty());
        }
        assert_eq!(Mode::Triangles.triangles(7), (2, 1));
        assert!(Mode::of_code(7).is_none());
    }

    #[test]
    fn corners_get_their_own_vertices() {
        assert_eq!(per_corner(&['a', 'b', 'c', 'd'], &[[0, 1, 2], [2, 1, 3]]), ['a', 'b', 'c', 'c', 'b', 'd']);
    }
}
