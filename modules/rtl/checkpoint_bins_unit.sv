// Checkpoint unit of the RT unit for lists in bins of distance: which ring an entry goes to, which one a round reads
// next, addresses, combining writes, the queues of both directions. Entries of 8 B, so each ends with its sector or
// inside it. Pins and timing: docs/model/rtl_bridge.md; bins: docs/model/checkpoint_unit.md. Channels as in
// checkpoint_unit.sv, which has the two buffers of the paper.
module checkpoint_bins_unit #(
    parameter LANES = 4,         // items an edge
    parameter WRITE_QUEUE = 16,  // sectors
    parameter RAYS = 256,        // warp buffer entries x 32
    parameter NEAR = 4,          // rings around the circle, a power of two; one for all beyond them comes last
    parameter CAPACITY = 512,    // most places of a ring
    parameter RAY_BITS = $clog2(RAYS),
    parameter LEVEL_BITS = $clog2(WRITE_QUEUE + 1),
    parameter PLACE_BITS = $clog2(WRITE_QUEUE),
    parameter RINGS = NEAR + 1,
    parameter CIRCLE_BITS = $clog2(NEAR),
    parameter BIN_BITS = CIRCLE_BITS + 1,
    parameter RING_BITS = $clog2(CAPACITY + 1)
) (
    input  logic                     clk,
    input  logic                     rst,                // synchronous; loads base and size
    // Straps: constant while the unit works.
    input  logic [6:0]               cfg_lanes,          // 1 to LANES
    input  logic [LEVEL_BITS-1:0]    cfg_write_queue,    // 2 to WRITE_QUEUE
    input  logic                     cfg_write_combine,  // one open sector a ray
    input  logic                     cfg_read_buffer,
    input  logic [63:0]              cfg_base0,          // of ray 0's ring 0; rings begin on 128 B
    input  logic [19:0]              cfg_stride,         // bytes from a ring to the next
    input  logic [15:0]              cfg_size,           // places of a ring, a multiple of 4, two sectors at least
`ifdef CHECKPOINT_FAULTS
    input  logic [1:0]               fault,              // 1 comparison, 2 lost entry, 3 ring
`endif
    // A ray begins a round, with what its rings hold; one that does not replay finds them empty.
    input  logic                     begin_valid,
    output logic                     begin_ready,
    input  logic [RAY_BITS-1:0]      begin_ray,
    input  logic                     begin_replay,
    input  logic [31:0]              begin_enter,        // t at which the ray enters the scene
    input  logic [31:0]              begin_t_max,        // of the last round's end: nothing left lies before it
    input  logic [RINGS*RING_BITS-1:0] begin_head,       // as they were left
    input  logic [RINGS*RING_BITS-1:0] begin_held,
    input  logic [10:0]              begin_far,
    // What a ray whose round is over leaves for its next one: in each ring the first place and how many entries it
    // holds, and the lowest stretch of those in the far one.
    input  logic [RAY_BITS-1:0]      leave_ray,
    output logic [RINGS*RING_BITS-1:0] leave_head,
    output logic [RINGS*RING_BITS-1:0] leave_held,
    output logic [10:0]              leave_far,
    // A ray hands over entries; last: it has no further event in its round.
    input  logic                     submit_valid,
    output logic                     submit_ready,
    input  logic [RAY_BITS-1:0]      submit_ray,
    input  logic [7:0]               submit_entries,
    input  logic                     submit_last,
    output logic                     submit_wait,        // it waits until item_done
    // Rays in the order of their submissions: whose items come next.
    output logic [LANES-1:0]         front_valid,
    output logic [LANES*RAY_BITS-1:0] front_ray,
    // Their items, in that order; a prefix of them is taken.
    input  logic [LANES-1:0]         item_valid,
    output logic [LANES-1:0]         item_ready,
    output logic [LANES-1:0]         item_done,          // the ray has handed over all
    output logic [LANES-1:0]         item_before,        // t < t_min
    output logic [LANES-1:0]         item_beyond,        // t_max < t
    output logic [LANES*BIN_BITS-1:0] item_bin,          // the ring it goes to
    output logic [LANES-1:0]         item_overflow,      // no ring has room: it is dropped, the ray restarts at the root
    input  logic [LANES*RAY_BITS-1:0] item_ray,
    input  logic [LANES*48-1:0]      item_offset,        // of the ray's rings, from the base
    input  logic [LANES-1:0]         item_entry,         // an entry, else only the open sector
    input  logic [LANES-1:0]         item_end,           // the ray's last item of this submission
    input  logic [LANES-1:0]         item_last,          // and of its round
    input  logic [LANES*32-1:0]      item_t,
    input  logic [LANES*32-1:0]      item_t_min,
    input  logic [LANES*32-1:0]      item_t_max,
    input  logic [LANES*64-1:0]      item_data,
    // A ray reads its next source entry.
    input  logic                     read_valid,
    output logic                     read_ready,
    input  logic [RAY_BITS-1:0]      read_ray,
    input  logic [31:0]              read_t_max,
    output logic                     read_done,          // it is there: see part
    output logic                     read_refused,       // the round has read all that it may
    output logic                     read_beyond,        // what is left lies beyond t_max, and stays where it is
    output logic [BIN_BITS-1:0]      read_bin,
    // Where the rings of the ray lie whose sector is requested next.
    output logic [RAY_BITS-1:0]      look_ray,
    input  logic [47:0]              look_offset,
    // To memory: one sector.
    output logic                     req_valid,
    input  logic                     req_ready,
    output logic                     req_write,
    output logic [47:0]              req_address,
    output logic [RAY_BITS-1:0]      req_tag,            // of a read: the ray
    output logic [31:0]              req_mask,           // bytes to write
    output logic [255:0]             req_data,
    // From memory.
    input  logic                     rsp_valid,
    output logic                     rsp_ready,
    input  logic                     rsp_write,
    input  logic [RAY_BITS-1:0]      rsp_tag,
    input  logic [255:0]             rsp_data,
    // A source entry, valid with the transfer of read or rsp that it comes by.
    output logic                     part_valid,
    output logic [RAY_BITS-1:0]      part_ray,
    output logic [63:0]              part_data,
    // State.
    output logic [RAY_BITS:0]        submitted_level,
    output logic [RAY_BITS:0]        reads_level,
    output logic [LEVEL_BITS-1:0]    writes_level,
    output logic [15:0]              outstanding,
    output logic                     busy,
    output logic                     idle
);
`include "fp32.svh"
  localparam [BIN_BITS-1:0] FAR = BIN_BITS'(NEAR), NONE = {BIN_BITS{1'b1}};
  localparam NUMBER_BITS = 11;  // of a stretch of distance: exponent and three bits of the mantissa
  // Of each ring its first place, how many entries it holds and how many of them the round may still read.
  logic [RINGS*RING_BITS-1:0] ring_head [0:RAYS-1];
  logic [RINGS*RING_BITS-1:0] ring_held [0:RAYS-1];
  logic [RINGS*RING_BITS-1:0] ring_allowed [0:RAYS-1];
  // Where the ray enters the scene, stretch of the last round's t_max, ring of the last entry read (NONE: none yet),
  // lowest stretch of what the far ring holds.
  logic [31:0]            scene_enter [0:RAYS-1];
  logic [NUMBER_BITS-1:0] reached [0:RAYS-1];
  logic [BIN_BITS-1:0]    last_ring [0:RAYS-1];
  logic [NUMBER_BITS-1:0] far_from [0:RAYS-1];
  logic [63:0] base;
  logic [15:0] size;
  // The queues.
  logic [RAY_BITS-1:0] submitted [0:RAYS-1];
  logic [RAY_BITS-1:0] reads [0:RAYS-1];
  logic [47:0]  write_address [0:WRITE_QUEUE-1];
  logic [31:0]  write_mask [0:WRITE_QUEUE-1];
  logic [255:0] write_data [0:WRITE_QUEUE-1];
  // Switched on by straps. A tag is ring and place of a sector's first entry; ring NONE: none is open.
  logic [255:0] open_sectors [0:RAYS-1];
  logic [BIN_BITS+RING_BITS-1:0] open_tags [0:RAYS-1];
  logic [255:0] read_sectors [0:RAYS-1];
  // Control.
  logic [RAY_BITS-1:0]   submitted_head /*verilator public_flat_rd*/, reads_head /*verilator public_flat_rd*/;
  logic [PLACE_BITS-1:0] write_head /*verilator public_flat_rd*/;
  logic [WRITE_QUEUE-1:0] queued;     // places that hold a sector

  logic wrong_comparison, loses_entry, wrong_ring;
`ifdef CHECKPOINT_FAULTS
  assign wrong_comparison = fault == 2'd1;
  assign loses_entry = fault == 2'd2;
  assign wrong_ring = fault == 2'd3;
`else
  assign {wrong_comparison, loses_entry, wrong_ring} = 3'd0;
`endif

  // Number of the stretch in which t lies; what lies before the scene counts as its begin.
  function automatic logic [NUMBER_BITS-1:0] number_of(input logic [31:0] t, input logic [31:0] enter);
    logic [31:0] distance;
    distance = fp_add(t, {~enter[31], enter[30:0]});
    number_of = distance[31] ? '0 : distance[30:20];
  endfunction
  function [RING_BITS-1:0] of_ring(input [RINGS*RING_BITS-1:0] all, input [BIN_BITS-1:0] bin);
    of_ring = '0;
    for (int r = 0; r < RINGS; r = r + 1)
      of_ring = of_ring | (all[r*RING_BITS +: RING_BITS] & {RING_BITS{bin == BIN_BITS'(r)}});
  endfunction
  function [RINGS*RING_BITS-1:0] with_ring(input [RINGS*RING_BITS-1:0] all, input [BIN_BITS-1:0] bin,
                                           input [RING_BITS-1:0] value);
    for (int r = 0; r < RINGS; r = r + 1)
      with_ring[r*RING_BITS +: RING_BITS] = bin == BIN_BITS'(r) ? value : all[r*RING_BITS +: RING_BITS];
  endfunction
  // The place `ahead` places behind `from`, and the one before it.
  function [RING_BITS-1:0] place_of(input [RING_BITS-1:0] from, input [RING_BITS-1:0] ahead, input [15:0] places);
    logic [RING_BITS:0] sum;
    sum = {1'b0, from} + {1'b0, ahead};
    place_of = sum >= (RING_BITS+1)'(places) ? RING_BITS'(sum - (RING_BITS+1)'(places)) : RING_BITS'(sum);
  endfunction
  function [RING_BITS-1:0] place_before(input [RING_BITS-1:0] at, input [15:0] places);
    place_before = (at == '0 ? RING_BITS'(places) : at) - 1'b1;
  endfunction
  // First byte of the sector of a place.
  function [47:0] sector_of(input [47:0] offset, input [BIN_BITS-1:0] bin, input [RING_BITS-1:0] at);
    logic [47:0] ring;
    ring = '0;
    for (int b = 0; b < BIN_BITS; b = b + 1) ring = ring + (bin[b] ? {28'd0, cfg_stride} << b : 48'd0);
    sector_of = base[47:0] + offset + ring + 48'({at[RING_BITS-1:2], 5'd0});
  endfunction
  // Entries first to last of a sector, a bit each.
  function [3:0] entries(input [1:0] first, input [1:0] last);
    entries = (4'b1111 << first) & (4'b1111 >> (2'd3 - last));
  endfunction
  function [31:0] bytes(input [3:0] mask);
    for (int i = 0; i < 4; i = i + 1) bytes[i*8 +: 8] = {8{mask[i]}};
  endfunction
  function [PLACE_BITS-1:0] place(input [PLACE_BITS-1:0] head, input [LEVEL_BITS:0] ahead,
                                  input [LEVEL_BITS-1:0] depth);
    logic [LEVEL_BITS:0] sum;
    sum = (LEVEL_BITS+1)'(head) + ahead;
    place = sum >= {1'b0, depth} ? PLACE_BITS'(sum - {1'b0, depth}) : PLACE_BITS'(sum);
  endfunction

  // --- Requests: reads first, unless the sector still waits to be written.
  logic next_waits;
  logic [BIN_BITS-1:0] next_bin;
  logic [47:0] next_address;
  assign look_ray = reads[reads_head];
  assign next_bin = last_ring[look_ray];
  assign next_address = sector_of(look_offset, next_bin, place_before(of_ring(ring_head[look_ray], next_bin), size));
  always_comb begin
    next_waits = 1'b0;
    for (int i = 0; i < WRITE_QUEUE; i = i + 1) begin
      if (queued[i] && write_address[i] == next_address) next_waits = 1'b1;
    end
  end
  assign req_write = reads_level == 0 | next_waits;
  assign req_valid = ~req_write | writes_level != 0;
  assign req_address = req_write ? write_address[write_head] : next_address;
  assign req_tag = req_write ? '0 : look_ray;
  assign req_mask = write_mask[write_head];
  assign req_data = write_data[write_head];
  logic requested, write_sent;
  assign requested = req_valid & req_ready;
  assign write_sent = requested & req_write;

  // --- Submissions.
  assign submit_wait = submit_entries != 0 |
                       (submit_last & cfg_write_combine & open_tags[submit_ray][RING_BITS +: BIN_BITS] != NONE);
  assign submit_ready = 1'b1;  // a place for each ray
  logic submitting;
  assign submitting = submit_valid & submit_wait;
  always_comb begin
    for (int i = 0; i < LANES; i = i + 1) begin
      front_valid[i] = (RAY_BITS+1)'(i) < submitted_level;
      front_ray[i*RAY_BITS +: RAY_BITS] = submitted[submitted_head + RAY_BITS'(i)];
    end
  end

  // --- t-value validation and stretches of distance.
  logic [LANES*NUMBER_BITS-1:0] item_number, item_nearest;
  genvar lane;
  generate
    for (lane = 0; lane < LANES; lane = lane + 1) begin : validation
      logic beyond;
      logic [31:0] enter;
      assign item_before[lane] = fp_less(item_t[lane*32 +: 32], item_t_min[lane*32 +: 32]);
      assign beyond = fp_less(item_t_max[lane*32 +: 32], item_t[lane*32 +: 32]);
      assign item_beyond[lane] = beyond | (wrong_comparison & item_t[lane*32 +: 32] == item_t_max[lane*32 +: 32]);
      assign enter = scene_enter[item_ray[lane*RAY_BITS +: RAY_BITS]];
      assign item_number[lane*NUMBER_BITS +: NUMBER_BITS] = number_of(item_t[lane*32 +: 32], enter);
      assign item_nearest[lane*NUMBER_BITS +: NUMBER_BITS] = number_of(item_t_max[lane*32 +: 32], enter);
    end
  endgenerate

  // --- Items: a prefix of them, as far as cfg_lanes and the room in the write queue go.
  logic [LANES-1:0]      item_stored;              // an entry that is written
  logic [LANES*RINGS*RING_BITS-1:0] new_held;
  logic [LANES*256-1:0]  new_open;
  logic [LANES*(BIN_BITS+RING_BITS)-1:0] new_tag;
  logic [LANES*NUMBER_BITS-1:0] new_far;
  logic [2*LANES-1:0]    push;                     // an entry's sector, and one that is open at the end of the round
  logic [2*LANES*48-1:0] push_address;
  logic [2*LANES*32-1:0] push_mask;
  logic [2*LANES*256-1:0] push_data;
  logic [2*LANES*PLACE_BITS-1:0] push_place;
  logic [LEVEL_BITS:0]   pushes;
  logic [6:0]            rays_done;
  logic [LEVEL_BITS:0]   room;
  logic [6:0]            budget;
  logic                  walking, same, far_side, to_far, found, match, complete, closes, open_left;
  logic [RAY_BITS-1:0]   ray, previous;
  logic [RINGS*RING_BITS-1:0] head, held;
  logic [NUMBER_BITS-1:0] nearest, number, far;
  logic [NUMBER_BITS:0]  behind;
  logic [CIRCLE_BITS-1:0] steps, turn;
  logic [BIN_BITS-1:0]   bin, open_bin;
  logic [RING_BITS-1:0]  at, open_at, ring_level;
  logic [1:0]            begun, open_end;
  logic [255:0]          opened, merged;
  always_comb begin
    // What leaves the queue at this edge makes room at this edge.
    room = {1'b0, cfg_write_queue} - {1'b0, writes_level} + {{LEVEL_BITS{1'b0}}, write_sent};
    budget = cfg_lanes;
    pushes = '0;
    rays_done = '0;
    walking = 1'b1;
    previous = '0;
    {head, held, opened, open_bin, open_at, far} = '0;
    {ray, same, far_side, to_far, found, match, complete, closes, open_left, nearest, number, behind, steps, turn} = '0;
    {bin, at, ring_level, begun, open_end, merged} = '0;
    for (int i = 0; i < LANES; i = i + 1) begin
      ray = item_ray[i*RAY_BITS +: RAY_BITS];
      same = i != 0 && ray == previous;
      head = ring_head[ray];
      if (!same) begin
        held = ring_held[ray];
        opened = open_sectors[ray];
        {open_bin, open_at} = open_tags[ray];
        far = far_from[ray];
      end
      if (!cfg_write_combine) open_bin = NONE;
      previous = ray;
      // The ring: near ones begin at t_max; one that is full gives its entry to the one before it.
      nearest = item_nearest[i*NUMBER_BITS +: NUMBER_BITS];
      number = item_number[i*NUMBER_BITS +: NUMBER_BITS];
      behind = {1'b0, nearest} + (NUMBER_BITS+1)'(NEAR);
      far_side = {1'b0, number} >= behind;
      to_far = far_side & held[NEAR*RING_BITS +: RING_BITS] != RING_BITS'(size);
      steps = far_side ? CIRCLE_BITS'(NEAR - 1) : CIRCLE_BITS'(number - nearest);
      found = 1'b0;
      bin = FAR;
      for (int s = NEAR - 1; s >= 0; s = s - 1) begin
        turn = nearest[CIRCLE_BITS-1:0] + CIRCLE_BITS'(s);
        if (!to_far && !found && CIRCLE_BITS'(s) <= steps && of_ring(held, {1'b0, turn}) != RING_BITS'(size)) begin
          found = 1'b1;
          bin = {1'b0, turn};
        end
      end
      item_overflow[i] = ~to_far & ~found;
      if (wrong_ring && !to_far) bin[0] = ~bin[0];
      item_bin[i*BIN_BITS +: BIN_BITS] = bin;
      item_stored[i] = item_entry[i] & item_beyond[i] & ~item_before[i] & ~item_overflow[i];
      // One place for the sector that an item may complete.
      walking = walking & item_valid[i] & budget != 0 & room != 0;
      item_ready[i] = walking;
      ring_level = of_ring(held, bin);
      at = place_of(of_ring(head, bin), ring_level, size);
      match = open_bin == bin & open_at[RING_BITS-1:2] == at[RING_BITS-1:2];
      begun = match ? open_at[1:0] : at[1:0];
      complete = ~cfg_write_combine | at[1:0] == 2'd3;
      closes = ~complete & ~match & open_bin != NONE;  // the open sector, of another ring
      merged = opened;
      for (int e = 0; e < 4; e = e + 1) if (at[1:0] == 2'(e)) merged[e*64 +: 64] = item_data[i*64 +: 64];
      // Entries of a ring lie one behind the other, so its open sector ends where the ring does.
      open_end = 2'(of_ring(head, open_bin)) + 2'(of_ring(held, open_bin)) - 2'd1;
      push[2*i] = walking & item_stored[i] & (complete | closes) & ~(loses_entry & complete & at == RING_BITS'(3));
      push_place[(2*i)*PLACE_BITS +: PLACE_BITS] = place(write_head, {1'b0, writes_level} + pushes, cfg_write_queue);
      push_address[(2*i)*48 +: 48] =
          sector_of(item_offset[i*48 +: 48], closes ? open_bin : bin, closes ? open_at : at);
      push_mask[(2*i)*32 +: 32] = bytes(closes ? entries(open_at[1:0], open_end) : entries(begun, at[1:0]));
      push_data[(2*i)*256 +: 256] = closes ? opened : merged;
      if (item_stored[i]) begin
        if (!complete) opened = merged;
        if (complete ? match : ~match) {open_bin, open_at} = {complete ? NONE : bin, at};
        if (to_far) begin
          if (ring_level == '0 || behind < {1'b0, far})
            far = behind[NUMBER_BITS] ? {NUMBER_BITS{1'b1}} : behind[NUMBER_BITS-1:0];
        end
        held = with_ring(held, bin, ring_level + 1'b1);
      end
      if (walking) begin
        budget = budget - 7'd1;
        room = room - {{LEVEL_BITS{1'b0}}, push[2*i]};
        pushes = pushes + {{LEVEL_BITS{1'b0}}, push[2*i]};
      end
      // What is open at the end of the round. A ray that hands over nothing else has paid for it already.
      open_left = item_end[i] & item_last[i] & open_bin != NONE;
      open_end = 2'(of_ring(head, open_bin)) + 2'(of_ring(held, open_bin)) - 2'd1;
      push[2*i+1] = walking & open_left & (~item_entry[i] | (budget != 0 & room != 0));
      push_place[(2*i+1)*PLACE_BITS +: PLACE_BITS] = place(write_head, {1'b0, writes_level} + pushes, cfg_write_queue);
      push_address[(2*i+1)*48 +: 48] = sector_of(item_offset[i*48 +: 48], open_bin, open_at);
      push_mask[(2*i+1)*32 +: 32] = bytes(entries(open_at[1:0], open_end));
      push_data[(2*i+1)*256 +: 256] = opened;
      if (push[2*i+1]) begin
        room = room - 1'b1;
        pushes = pushes + 1'b1;
        open_bin = NONE;
        if (item_entry[i]) budget = budget - 7'd1;
      end
      new_held[i*RINGS*RING_BITS +: RINGS*RING_BITS] = held;
      new_open[i*256 +: 256] = opened;
      new_tag[i*(BIN_BITS+RING_BITS) +: BIN_BITS+RING_BITS] = {open_bin, open_at};
      new_far[i*NUMBER_BITS +: NUMBER_BITS] = far;
      item_done[i] = walking & item_end[i] & (~open_left | push[2*i+1]);
      rays_done = rays_done + {6'd0, item_done[i]};
      walking = walking & (~item_end[i] | item_done[i]);
    end
  end

  // --- Reading: the next ring with something for the round, and its stretch against that of t_max. A round that begins
  // measures the t_max it is given with the same subtraction.
  logic [NUMBER_BITS-1:0] measured;
  logic                   near_any, far_any, far_next, read_held, reading;
  logic [CIRCLE_BITS-1:0] near_steps, near_turn;
  logic [NUMBER_BITS:0]   near_number, read_number;
  logic [RINGS*RING_BITS-1:0] read_heads, read_helds, read_alloweds, begin_helds, begin_heads;
  logic [RING_BITS-1:0]   read_at;
  assign measured = number_of(begin_valid ? begin_t_max : read_t_max,
                              begin_valid ? begin_enter : scene_enter[read_ray]);
  assign leave_head = ring_head[leave_ray];
  assign leave_held = ring_held[leave_ray];
  assign leave_far = far_from[leave_ray];
  assign read_heads = ring_head[read_ray];
  assign read_helds = ring_held[read_ray];
  assign read_alloweds = ring_allowed[read_ray];
  always_comb begin
    near_any = 1'b0;
    near_steps = '0;
    near_turn = '0;
    for (int s = NEAR - 1; s >= 0; s = s - 1) begin
      near_turn = reached[read_ray][CIRCLE_BITS-1:0] + CIRCLE_BITS'(s);
      if (of_ring(read_alloweds, {1'b0, near_turn}) != '0) begin
        near_any = 1'b1;
        near_steps = CIRCLE_BITS'(s);
      end
    end
  end
  assign near_number = {1'b0, reached[read_ray]} + (NUMBER_BITS+1)'(near_steps);
  assign far_any = read_alloweds[NEAR*RING_BITS +: RING_BITS] != '0;
  assign far_next = far_any & (~near_any | {1'b0, far_from[read_ray]} <= near_number);
  assign read_number = far_next ? {1'b0, far_from[read_ray]} : near_number;
  assign read_bin = far_next ? FAR : {1'b0, reached[read_ray][CIRCLE_BITS-1:0] + near_steps};
  assign read_refused = ~near_any & ~far_any;
  assign read_beyond = read_number > {1'b0, measured};
  assign read_at = of_ring(read_heads, read_bin);
  // The sector that ends with the entry before is held, if that was this round's.
  assign read_held = cfg_read_buffer & read_at[1:0] != 0 & last_ring[read_ray] == read_bin;
  assign read_done = read_held & ~read_refused & ~read_beyond;
  assign read_ready = ~rsp_valid & ~begin_valid;  // parts have one way out, t_max one subtraction
  assign begin_ready = 1'b1;
  assign rsp_ready = 1'b1;
  assign reading = read_valid & read_ready & ~read_refused & ~read_beyond;
  always_comb begin
    begin_helds = begin_replay ? begin_held : '0;
    begin_heads = begin_head;
    for (int r = 0; r < RINGS; r = r + 1) begin  // an empty ring starts at its first place
      if (begin_helds[r*RING_BITS +: RING_BITS] == '0) begin_heads[r*RING_BITS +: RING_BITS] = '0;
    end
  end
  // Entries: of a sector that has come, or of the one that the ray holds.
  logic arrived;
  logic [1:0] part_at;
  logic [255:0] part_sector;
  assign arrived = rsp_valid & ~rsp_write;
  assign part_ray = rsp_valid ? rsp_tag : read_ray;
  assign part_at = rsp_valid ? 2'(of_ring(ring_head[rsp_tag], last_ring[rsp_tag])) - 2'd1 : read_at[1:0];
  assign part_sector = arrived ? rsp_data : cfg_read_buffer ? read_sectors[part_ray] : '0;
  assign part_data = 64'(part_sector >> {part_at, 6'd0});
  assign part_valid = arrived | (reading & read_done);

  assign busy = submitted_level != 0 | reads_level != 0 | writes_level != 0;
  assign idle = ~busy & outstanding == 0;

  always_ff @(posedge clk) begin
    if (rst) begin
      base <= cfg_base0;
      size <= cfg_size;
      submitted_head <= '0;
      submitted_level <= '0;
      reads_head <= '0;
      reads_level <= '0;
      write_head <= '0;
      writes_level <= '0;
      queued <= '0;
      outstanding <= '0;
    end else begin
      submitted_head <= submitted_head + RAY_BITS'(rays_done);
      submitted_level <= submitted_level + {{RAY_BITS{1'b0}}, submitting} - (RAY_BITS+1)'(rays_done);
      if (requested & ~req_write) reads_head <= reads_head + 1'b1;
      reads_level <= reads_level + {{RAY_BITS{1'b0}}, reading & ~read_done} - {{RAY_BITS{1'b0}}, requested & ~req_write};
      if (write_sent) begin
        write_head <= place(write_head, 1, cfg_write_queue);
        queued[write_head] <= 1'b0;
      end
      writes_level <= LEVEL_BITS'({1'b0, writes_level} + pushes - {{LEVEL_BITS{1'b0}}, write_sent});
      for (int i = 0; i < 2 * LANES; i = i + 1) begin
        if (push[i]) queued[push_place[i*PLACE_BITS +: PLACE_BITS]] <= 1'b1;
      end
      outstanding <= outstanding + {15'd0, requested} - {15'd0, rsp_valid};
    end
  end

  // What reset leaves as it is.
  always_ff @(posedge clk) begin
    if (begin_valid) begin
      ring_head[begin_ray] <= begin_heads;
      ring_held[begin_ray] <= begin_helds;
      ring_allowed[begin_ray] <= begin_helds;
      reached[begin_ray] <= measured;
      last_ring[begin_ray] <= NONE;
      if (cfg_write_combine) open_tags[begin_ray] <= {NONE, RING_BITS'(0)};
      scene_enter[begin_ray] <= begin_enter;
      far_from[begin_ray] <= begin_far;
    end
    if (submitting) submitted[submitted_head + submitted_level[RAY_BITS-1:0]] <= submit_ray;
    if (reading) begin
      ring_head[read_ray] <= with_ring(read_heads, read_bin, place_of(read_at, 1, size));
      ring_held[read_ray] <= with_ring(read_helds, read_bin, of_ring(read_helds, read_bin) - 1'b1);
      ring_allowed[read_ray] <= with_ring(read_alloweds, read_bin, of_ring(read_alloweds, read_bin) - 1'b1);
      last_ring[read_ray] <= read_bin;
    end
    if (reading & ~read_done) reads[reads_head + reads_level[RAY_BITS-1:0]] <= read_ray;
    // When a ray has several items, the last one counts.
    for (int i = 0; i < LANES; i = i + 1) begin
      if (item_ready[i]) begin
        ring_held[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_held[i*RINGS*RING_BITS +: RINGS*RING_BITS];
        far_from[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_far[i*NUMBER_BITS +: NUMBER_BITS];
        if (cfg_write_combine) begin
          open_sectors[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_open[i*256 +: 256];
          open_tags[item_ray[i*RAY_BITS +: RAY_BITS]] <=
              new_tag[i*(BIN_BITS+RING_BITS) +: BIN_BITS+RING_BITS];
        end
      end
    end
    for (int i = 0; i < 2 * LANES; i = i + 1) begin
      if (push[i]) begin
        write_address[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_address[i*48 +: 48];
        write_mask[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_mask[i*32 +: 32];
        write_data[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_data[i*256 +: 256];
      end
    end
    if (cfg_read_buffer & arrived) read_sectors[part_ray] <= rsp_data;
  end
endmodule
