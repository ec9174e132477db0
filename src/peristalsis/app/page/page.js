// Parts of the page: found by their id, or made with their properties and what is in them.

export const $ = (id) => document.getElementById(id);

export const make = (kind, properties = {}, ...children) => {
  const made = Object.assign(document.createElement(kind), properties);
  made.append(...children);
  return made;
};
