//! Plots of a study: curves for a grid with one varied key, maps for a grid with two keys, and
//! scatter plots over each key for other designs.

use stiction_draw::figure::meaning::RESULT;
use stiction_draw::figure::{Figure, Line, Panel};
use stiction_draw::heat_map::HeatMap;
use stiction_format::{Key, Setting};

/// Largest number of rows of a grid that is drawn as curves or maps; larger grids are drawn as
/// scatter plots.
const MOST_ROWS: u64 = 100_000;
/// Largest number of rows in a scatter plot. More marks would hide each other.
const MOST_MARKS: usize = 2000;
/// Largest number of keys with scatter plots.
const MOST_KEYS: usize = 8;

/// Collects the rows of a study and draws the plots of the study.
pub struct Pictures {
    keys: Vec<String>,
    objectives: Vec<String>,
    /// Number of values of each key of a grid with one or two keys; `None` for other designs and
    /// for grids with too many rows.
    shape: Option<Vec<usize>>,
    /// Values of the keys in each stored row; NaN for values that are not numbers.
    settings: Vec<Vec<f64>>,
    values: Vec<Vec<Option<f64>>>,
    /// Number of rows added so far.
    rows: usize,
    /// Number of rows from each stored row to the next.
    stride: usize,
}

/// Returns the file name of picture `index` out of `count` pictures.
fn file(index: usize, count: usize) -> String {
    match count {
        1 => "sweep.svg".to_owned(),
        _ => format!("sweep-{}.svg", index + 1),
    }
}

/// Plot of a study.
pub(super) enum Picture {
    Curves(Figure),
    Map(HeatMap),
}

impl Pictures {
    /// Creates an empty collector; `shape` contains the number of values of each key if the design is a grid.
    pub fn new(keys: &[Key], objectives: &[String], shape: Option<&[u64]>) -> Self {
        let is_drawn = |shape: &&[u64]| {
            matches!(shape.len(), 1 | 2) && shape.iter().product::<u64>() <= MOST_ROWS
        };
        let shape = shape.filter(is_drawn);
        Self {
            keys: keys.iter().map(Key::to_string).collect(),
            objectives: objectives.to_vec(),
            shape: shape.map(|shape| shape.iter().map(|count| *count as usize).collect()),
            settings: Vec::new(),
            values: Vec::new(),
            rows: 0,
            stride: 1,
        }
    }

    /// Adds the next row of the study.
    pub fn add(&mut self, settings: &[Setting], values: &[Option<f64>]) {
        let is_kept = self.rows.is_multiple_of(self.stride);
        self.rows += 1;
        if !is_kept {
            return;
        }
        if self.shape.is_none() && self.settings.len() == MOST_MARKS {
            self.stride *= 2;
            let mut index = 0..;
            self.settings.retain(|_| index.next().is_some_and(|k| k % 2 == 0));
            let mut index = 0..;
            self.values.retain(|_| index.next().is_some_and(|k| k % 2 == 0));
        }
        let number = |setting: &Setting| match setting {
            Setting::Number(number) => *number,
            Setting::Text(_) => f64::NAN,
        };
        self.settings.push(settings.iter().map(number).collect());
        self.values.push(values.to_vec());
    }

    /// Draws all plots as SVG, with their file names. For a grid with one or two keys, returns no
    /// plots if a key has values that are not numbers, or if rows are missing.
    pub fn draw(&self) -> Vec<(String, String)> {
        let svg = |picture: &Picture| match picture {
            Picture::Curves(figure) => figure.svg(),
            Picture::Map(map) => map.svg(),
        };
        self.all().into_iter().map(|(name, picture)| (name, svg(&picture))).collect()
    }

    /// Returns all plots with their file names.
    pub(super) fn all(&self) -> Vec<(String, Picture)> {
        let is_numeric = self.settings.iter().flatten().all(|number| number.is_finite());
        let Some(shape) = &self.shape else { return self.scatter() };
        if !is_numeric || self.values.len() != shape.iter().product::<usize>() {
            return Vec::new();
        }
        match shape.as_slice() {
            [_] => vec![("sweep.svg".to_owned(), Picture::Curves(self.curves()))],
            [rows, columns] => (0..self.objectives.len())
                .map(|k| {
                    (file(k, self.objectives.len()), Picture::Map(self.map(k, *rows, *columns)))
                })
                .collect(),
            _ => Vec::new(),
        }
    }

    /// Draws scatter plots of all objectives over each key whose values are numbers, for at most
    /// [`MOST_KEYS`] keys.
    fn scatter(&self) -> Vec<(String, Picture)> {
        let is_numeric = |key: &usize| {
            !self.settings.is_empty() && self.settings.iter().all(|row| row[*key].is_finite())
        };
        let numeric: Vec<usize> = (0..self.keys.len()).filter(is_numeric).collect();
        let shown = &numeric[..numeric.len().min(MOST_KEYS)];
        let part = match self.stride {
            1 => String::new(),
            stride => format!("; one of every {stride} designs is drawn"),
        };
        let figure = |key: usize| {
            let panel = |(k, objective): (usize, &String)| {
                let rows = self.settings.iter().zip(&self.values);
                let points = rows.filter_map(|(x, values)| Some((x[key], values[k]?)));
                let lines = vec![Line::of_marks(points, RESULT)];
                Panel { y_label: objective.clone(), lines, ..Panel::default() }
            };
            Figure {
                title: format!("Over {}{part}", self.keys[key]),
                x_label: self.keys[key].clone(),
                panels: self.objectives.iter().enumerate().map(panel).collect(),
            }
        };
        let figures = shown.iter().map(|key| figure(*key)).filter(|figure| !figure.is_empty());
        figures
            .enumerate()
            .map(|(k, figure)| (file(k, shown.len()), Picture::Curves(figure)))
            .collect()
    }

    fn curves(&self) -> Figure {
        let panel = |(k, objective): (usize, &String)| {
            let points = self.settings.iter().zip(&self.values);
            let points = points.filter_map(|(x, values)| Some((x[0], values[k]?))).collect();
            let line = Line { label: String::new(), points, colour: RESULT, dashed: false };
            Panel { y_label: objective.clone(), lines: vec![line], ..Panel::default() }
        };
        Figure {
            title: format!("Over {}", self.keys[0]),
            x_label: self.keys[0].clone(),
            panels: self.objectives.iter().enumerate().map(panel).collect(),
        }
    }

    fn map(&self, objective: usize, rows: usize, columns: usize) -> HeatMap {
        let row = |row: usize| {
            (0..columns).map(|column| self.values[row * columns + column][objective]).collect()
        };
        HeatMap {
            title: self.objectives[objective].clone(),
            x_label: self.keys[1].clone(),
            y_label: self.keys[0].clone(),
            x: (0..columns).map(|column| self.settings[column][1]).collect(),
            y: (0..rows).map(|row| self.settings[row * columns][0]).collect(),
            values: (0..rows).map(row).collect(),
        }
    }
}
