// SPDX-License-Identifier: Apache-2.0
// What an event did, in words.
import { counted, hex, time } from './dom.js';
import { gaussian_name, is_wide, node_name, nodes } from './nodes.js';
import { page } from './page.js';
import { summary } from './position.js';

const entries_text = (list) => `${list.length} ${list.length === 1 ? 'entry' : 'entries'}`;
const count_of_bytes = (event) => {
  if (event.kind === 'internal') return page.reads.internal;
  if (is_wide(event.node)) return page.reads.wide;
  return event.kind === 'instance' ? page.reads.instance : page.reads.leaf;
};
export const read_text = (event) => {
  if (event.kind === 'cull' || event.kind === 'forward') return 'no node';
  if (event.kind === 'take') return `a checkpoint entry, ${page.entry_bytes.checkpoint} B`;
  const at = nodes().address[event.node],
    bytes = count_of_bytes(event),
    sectors = Math.floor((at + bytes - 1) / 32) - Math.floor(at / 32) + 1;
  const below = event.kind === 'instance' && !event.transforms && page.reads.header > 0;
  return `${bytes} B at ${hex(at)} (${sectors} sectors)${below ? `, and the header below it, ${page.reads.header} B` : ''}`;
};

const kWhatBecame = {
  behind: ', before t_min: blended already',
  beyond: ', beyond t_max',
  inserted: ', inserted',
  displaced: ', inserted, the last one falls out',
  rejected: ', rejected',
  ignored: ', ignored',
  nearest: ', nearest so far',
};
const leaf_headline = ({ node, hit, outcome }) => {
  if (outcome.name === 'miss') return `${node_name(node)} missed`;
  const at = Number.isNaN(hit.t) ? '' : ` at t = ${time(hit.t)}`;
  return `${node_name(node)} hit: ${gaussian_name(hit)}${at}${kWhatBecame[outcome.name]}`;
};
const kHeadlines = {
  internal: ({ pushed, written }, name) => {
    const kept = written.length > 0 ? `, ${written.length} checkpointed` : '';
    return `${name}: ${pushed.length} of its children pushed${kept}`;
  },
  instance: ({ transforms, pushed }, name) =>
    transforms ? `${name}: the ray is transformed again` : `${name}: the ray is transformed, ${node_name(pushed[0].node)} pushed`,
  leaf: leaf_headline,
  cull: (event, name) => `${name} lies beyond t_max: popped, not read`,
  take: ({ read }, name) => `Entry ${read} taken: ${name}`,
  forward: ({ read }, name) => `Entry ${read} lies beyond t_max: ${name} not read`,
};
export const headline = (event) => kHeadlines[event.kind](event, node_name(event.node));

const moved_text = ({ shifts }) => {
  if (shifts === 0 || page.tracing === 'closest') return '';
  return `; ${shifts} ${shifts === 1 ? 'entry moves' : 'entries move'} ${page.sorted ? 'one place back' : 'in the heap'}`;
};
const hidden_text = ({ hidden }) =>
  `${hidden} ${hidden === 1 ? 'entry' : 'entries'} at the end of the k-buffer ${hidden === 1 ? 'leaves' : 'leave'}: the hits before let no light through`;
export const copied = (event) => {
  const texts = [];
  if (event.place >= 0) texts.push(`${gaussian_name(event.hit)} to place ${event.place} of the k-buffer${moved_text(event)}`);
  if (event.hidden > 0) texts.push(hidden_text(event));
  if (event.evicted !== null)
    texts.push(
      page.checkpoint
        ? `${gaussian_name(event.evicted)} to the eviction list, ${page.entry_bytes.eviction} B`
        : `${gaussian_name(event.evicted)} is dropped: the next round meets it again`,
    );
  if (event.kind === 'take') texts.push('the entry to the stack');
  if (event.written.length > 0)
    texts.push(
      `${entries_text(event.written)} to the list that the next round reads, ${event.written.length * page.entry_bytes.checkpoint} B`,
    );
  else if (event.kind === 'cull' || event.kind === 'forward' || (event.outcome !== null && event.outcome.name === 'beyond'))
    texts.push(page.checkpoint ? 'nothing: dropped' : 'nothing: the next round starts at the root');
  return texts;
};

export const begin_text = (r) => {
  const s = summary(r);
  const texts = [
    s.replay
      ? 'The round goes on from the checkpoints of the one before. Its stack is empty.'
      : r === 0
        ? 'The ray begins at the root.'
        : 'The round starts at the root again.',
  ];
  if (s.preloaded > 0)
    texts.push(
      s.preloaded === 1 ? 'One hit comes from the eviction list.' : `${s.preloaded} hits come from the eviction list, the nearest first.`,
    );
  return texts;
};
export const end_text = (r) => {
  const s = summary(r);
  const light = s.transmittance === undefined ? '' : `; light let through ${time(s.transmittance)}`;
  const end = s.terminated ? '. The ray is opaque and ends' : s.overflow ? '. The checkpoint list ran full: it is dropped' : '';
  return `The round is over: ${counted(s.hits, 'hit')} in the k-buffer, ${s.processed} looked at, ${s.blended} blended${light}${end}.`;
};
