//! Lists: `?limit=&cursor=` in, `{items, next_cursor}` out, in a stable order.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::problem::Problem;

/// Items of a page when the call names no number.
const DEFAULT_LIMIT: u32 = 100;
/// Most items of a page.
const MAX_LIMIT: u32 = 1000;

/// Which page of a list is wanted.
#[derive(Debug, Clone, Default, Deserialize, IntoParams)]
#[into_params(parameter_in = Query)]
#[serde(deny_unknown_fields)]
pub struct PageQuery {
    /// Most items to give.
    #[param(minimum = 1, maximum = 1000, default = 100)]
    pub limit: Option<u32>,
    /// `next_cursor` of the page before.
    pub cursor: Option<String>,
}

/// A part of a list.
#[derive(Debug, Serialize, ToSchema)]
pub struct Page<T> {
    /// The items, in the list's order.
    pub items: Vec<T>,
    /// Give this as `cursor` for what follows; null at the end.
    pub next_cursor: Option<String>,
}

/// Which rows of a list are wanted.
pub struct Paging<K> {
    /// Most rows.
    pub limit: u32,
    /// The key of the last row before them.
    pub after: Option<K>,
}

impl<K: std::str::FromStr> Paging<K> {
    /// As a query has them.
    pub fn read(limit: Option<u32>, cursor: Option<&str>) -> Result<Self, Problem> {
        let limit = self::limit(limit)?;
        let wrong = || Problem::field("#cursor", "is not a next_cursor of this list");
        let after = cursor.map(|text| text.parse().map_err(|_| wrong())).transpose()?;
        Ok(Self { limit, after })
    }
}

/// The most items of a page.
pub fn limit(wanted: Option<u32>) -> Result<u32, Problem> {
    match wanted.unwrap_or(DEFAULT_LIMIT) {
        limit @ 1..=MAX_LIMIT => Ok(limit),
        other => Err(Problem::field("#limit", format!("{other} is not between 1 and {MAX_LIMIT}"))),
    }
}

impl<T> Page<T> {
    /// The whole list as one page.
    pub fn whole(items: impl IntoIterator<Item = impl Into<T>>) -> Self {
        Self { items: items.into_iter().map(Into::into).collect(), next_cursor: None }
    }

    /// A page of `limit` rows; `key` is what the next page starts after.
    pub fn of<R>(rows: Vec<R>, limit: u32, key: impl Fn(&R) -> String, render: impl Fn(R) -> T) -> Self {
        let render = |row| Ok::<T, Infallible>(render(row));
        let Ok(page) = Self::try_of(rows, limit, key, render);
        page
    }

    /// A page of rows that may not render.
    ///
    /// # Errors
    /// The first error of `render`.
    pub fn try_of<R, E>(
        rows: Vec<R>,
        limit: u32,
        key: impl Fn(&R) -> String,
        render: impl Fn(R) -> Result<T, E>,
    ) -> Result<Self, E> {
        let full = rows.len() as u64 >= u64::from(limit);
        let next_cursor = rows.last().filter(|_| full).map(key);
        Ok(Self { items: rows.into_iter().map(render).collect::<Result<_, _>>()?, next_cursor })
    }
}
