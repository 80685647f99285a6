// SPDX-License-Identifier: Apache-2.0
// Checkpoint unit of the RT unit: t-value validation, addresses of entries in two buffers that swap by round, combining
// writes, the queues of both directions. Pins and timing: docs/model/rtl_bridge.md. Paper: GRTX, Section IV-B.
// An item is an entry that a ray hands over, or the rest of its open sector. All channels move at the rising edge at
// which valid and ready are high; none of them waits for another's ready before it raises its valid.
module checkpoint_unit #(
    parameter LANES = 4,         // items an edge
    parameter WRITE_QUEUE = 16,  // sectors
    parameter RAYS = 256,        // warp buffer entries x 32
    parameter RAY_BITS = $clog2(RAYS),
    parameter LEVEL_BITS = $clog2(WRITE_QUEUE + 1),
    parameter PLACE_BITS = $clog2(WRITE_QUEUE)
) (
    input  logic                     clk,
    input  logic                     rst,                // synchronous; loads the bases and the size
    // Straps: constant while the unit works.
    input  logic [6:0]               cfg_lanes,          // 1 to LANES
    input  logic [LEVEL_BITS-1:0]    cfg_write_queue,    // 2 to WRITE_QUEUE
    input  logic                     cfg_write_combine,
    input  logic                     cfg_read_buffer,
    input  logic [4:0]               cfg_entry_bytes,    // 8, 16, 20 or 28
    input  logic [63:0]              cfg_base0,          // of buffer 0; buffers begin on 32 B
    input  logic [63:0]              cfg_base1,
    input  logic [15:0]              cfg_size,           // entries of a buffer
`ifdef CHECKPOINT_FAULTS
    input  logic [1:0]               fault,              // 1 comparison, 2 lost entry, 3 offset
`endif
    // A ray begins a round.
    input  logic                     begin_valid,
    output logic                     begin_ready,
    input  logic [RAY_BITS-1:0]      begin_ray,
    input  logic                     begin_replay,       // reads its source buffer
    // A ray hands over entries; last: it has no further event in its round.
    input  logic                     submit_valid,
    output logic                     submit_ready,
    input  logic [RAY_BITS-1:0]      submit_ray,
    input  logic [7:0]               submit_entries,
    input  logic                     submit_last,
    output logic                     submit_wait,        // it waits until item_done
    output logic                     submit_overflow,    // its buffer is too small: it restarts at the root
    output logic [15:0]              submit_end,         // entries of its round with these
    // Rays in the order of their submissions: whose items come next.
    output logic [LANES-1:0]         front_valid,
    output logic [LANES*RAY_BITS-1:0] front_ray,
    // Their items, in that order; a prefix of them is taken.
    input  logic [LANES-1:0]         item_valid,
    output logic [LANES-1:0]         item_ready,
    output logic [LANES-1:0]         item_done,          // the ray has handed over all
    output logic [LANES-1:0]         item_before,        // t < t_min
    output logic [LANES-1:0]         item_beyond,        // t_max < t
    output logic [LANES-1:0]         item_straddles,     // taken, and lies in two sectors
    input  logic [LANES*RAY_BITS-1:0] item_ray,
    input  logic [LANES-1:0]         item_parity,        // round mod 2: the buffer to write
    input  logic [LANES*48-1:0]      item_offset,        // of the ray's buffers, from the bases
    input  logic [LANES-1:0]         item_entry,         // an entry, else only the open sector
    input  logic [LANES-1:0]         item_end,           // the ray's last item of this submission
    input  logic [LANES-1:0]         item_last,          // and of its round
    input  logic [LANES*32-1:0]      item_t,
    input  logic [LANES*32-1:0]      item_t_min,
    input  logic [LANES*32-1:0]      item_t_max,
    input  logic [LANES*224-1:0]     item_data,
    // A ray reads its next source entry.
    input  logic                     read_valid,
    output logic                     read_ready,
    input  logic [RAY_BITS-1:0]      read_ray,
    output logic                     read_done,          // it is there: see part
    output logic                     read_refused,       // it does not replay, or has read all
    output logic                     read_straddles,
    // Where the buffers of the ray lie whose read is next at the front: the one behind it, or read_ray.
    output logic [RAY_BITS-1:0]      look_ray,
    input  logic                     look_parity,
    input  logic [47:0]              look_offset,
    // To memory: one sector.
    output logic                     req_valid,
    input  logic                     req_ready,
    output logic                     req_write,
    output logic [47:0]              req_address,
    output logic [RAY_BITS:0]        req_tag,            // of a read: {second sector, ray}
    output logic [31:0]              req_mask,           // bytes to write
    output logic [255:0]             req_data,
    // From memory.
    input  logic                     rsp_valid,
    output logic                     rsp_ready,
    input  logic                     rsp_write,
    input  logic [RAY_BITS:0]        rsp_tag,
    input  logic [255:0]             rsp_data,
    // Bytes of a source entry, valid with the transfer of read or rsp that they come by.
    output logic                     part_valid,
    output logic                     part_done,          // with the entry's last bytes
    output logic [RAY_BITS-1:0]      part_ray,
    output logic [27:0]              part_mask,
    output logic [223:0]             part_data,
    // State.
    output logic [RAY_BITS:0]        submitted_level,
    output logic [RAY_BITS:0]        reads_level,
    output logic [LEVEL_BITS-1:0]    writes_level,
    output logic [15:0]              outstanding,
    output logic                     busy,
    output logic                     idle
);
`include "fp32.svh"
  // The paper's table: 33 bits a ray, two bases, one size.
  logic [15:0] source_offset [0:RAYS-1] /*verilator public_flat_rd*/;  // entries asked for
  logic [15:0] destination_offset [0:RAYS-1] /*verilator public_flat_rd*/;
  logic        replay_flag [0:RAYS-1];
  logic [63:0] base0, base1;
  logic [15:0] size;
  // The queues.
  logic [RAY_BITS-1:0] submitted [0:RAYS-1];
  logic [RAY_BITS-1:0] reads [0:RAYS-1];
  logic [47:0]  write_address [0:WRITE_QUEUE-1];
  logic [31:0]  write_mask [0:WRITE_QUEUE-1];
  logic [255:0] write_data [0:WRITE_QUEUE-1];
  // Switched on by straps.
  logic [255:0] open_sectors [0:RAYS-1];
  logic [255:0] read_sectors [0:RAYS-1];
  // Control.
  logic [RAY_BITS-1:0]   submitted_head /*verilator public_flat_rd*/, reads_head /*verilator public_flat_rd*/;
  logic [PLACE_BITS-1:0] write_head /*verilator public_flat_rd*/;
  // The sector that the read at the front asks for next, known an edge ahead.
  logic [42:0]           next_sector;
  logic                  next_second /*verilator public_flat_rd*/, next_last;  // second of two; no other follows
  logic [RAYS-1:0]       halves;      // two responses missing
  logic [WRITE_QUEUE-1:0] queued;     // places that hold a sector

  logic wrong_comparison, loses_entry, wrong_offset;
`ifdef CHECKPOINT_FAULTS
  assign wrong_comparison = fault == 2'd1;
  assign loses_entry = fault == 2'd2;
  assign wrong_offset = fault == 2'd3;
`else
  assign {wrong_comparison, loses_entry, wrong_offset} = 3'd0;
`endif

  // First byte of entry n of a buffer: a multiplication by a constant, one adder at most.
  function [20:0] byte_of(input [15:0] n, input [4:0] entry_bytes);
    case (entry_bytes)
      5'd8: byte_of = {2'd0, n, 3'd0};
      5'd16: byte_of = {1'd0, n, 4'd0};
      5'd20: byte_of = {1'd0, n, 4'd0} + {3'd0, n, 2'd0};
      default: byte_of = {n, 5'd0} - {3'd0, n, 2'd0};
    endcase
  endfunction
  function [27:0] bytes_of_entry(input [4:0] entry_bytes);
    case (entry_bytes)
      5'd8: bytes_of_entry = 28'h00000ff;
      5'd16: bytes_of_entry = 28'h000ffff;
      5'd20: bytes_of_entry = 28'h00fffff;
      default: bytes_of_entry = 28'hfffffff;
    endcase
  endfunction
  function straddles_at(input [4:0] at, input [4:0] entry_bytes);
    straddles_at = {1'd0, at} + {1'd0, entry_bytes} > 6'd32;
  endfunction
  function [255:0] bits_of(input [31:0] mask);
    for (int i = 0; i < 32; i = i + 1) bits_of[i*8 +: 8] = {8{mask[i]}};
  endfunction
  // Bytes below `at` of a sector; at > 0.
  function [31:0] below(input [4:0] at);
    below = (32'd1 << at) - 32'd1;
  endfunction
  function [PLACE_BITS-1:0] place(input [PLACE_BITS-1:0] head, input [LEVEL_BITS:0] ahead,
                                  input [LEVEL_BITS-1:0] depth);
    logic [LEVEL_BITS:0] sum;
    sum = (LEVEL_BITS+1)'(head) + ahead;
    place = sum >= {1'b0, depth} ? PLACE_BITS'(sum - {1'b0, depth}) : PLACE_BITS'(sum);
  endfunction

  // --- Requests: reads first, unless the sector still waits to be written.
  logic [WRITE_QUEUE-1:0] next_waits;  // at these places
  always_comb begin
    for (int i = 0; i < WRITE_QUEUE; i = i + 1)
      next_waits[i] = queued[i] & write_address[i][47:5] == next_sector;
  end
  assign req_write = reads_level == 0 | (|next_waits);
  assign req_valid = reads_level != 0 | writes_level != 0;  // what a read waits for is in the queue
  assign req_address = req_write ? write_address[write_head] : {next_sector, 5'd0};
  assign req_tag = req_write ? '0 : {next_second, reads[reads_head]};
  assign req_mask = write_mask[write_head];
  assign req_data = write_data[write_head];
  logic requested, write_sent, read_sent, read_leaves;
  assign requested = req_valid & req_ready;
  assign write_sent = requested & req_write;
  assign read_sent = requested & ~req_write;
  assign read_leaves = read_sent & next_last;

  // --- Submissions.
  logic [15:0] submit_offset;
  logic [20:0] submit_begin;
  assign submit_offset = destination_offset[submit_ray];
  assign submit_begin = byte_of(submit_offset, cfg_entry_bytes);
  assign submit_end = submit_offset + {8'd0, submit_entries};
  assign submit_overflow = {1'b0, submit_offset} + {9'd0, submit_entries} > {1'b0, size};
  assign submit_wait = submit_entries != 0 | (submit_last & cfg_write_combine & submit_begin[4:0] != 0);
  assign submit_ready = 1'b1;  // a place for each ray
  assign begin_ready = 1'b1;
  logic submitting;
  assign submitting = submit_valid & submit_wait & ~submit_overflow;
  always_comb begin
    for (int i = 0; i < LANES; i = i + 1) begin
      front_valid[i] = (RAY_BITS+1)'(i) < submitted_level;
      front_ray[i*RAY_BITS +: RAY_BITS] = submitted[submitted_head + RAY_BITS'(i)];
    end
  end

  // --- t-value validation.
  genvar lane;
  generate
    for (lane = 0; lane < LANES; lane = lane + 1) begin : validation
      logic beyond;
      assign item_before[lane] = fp_less(item_t[lane*32 +: 32], item_t_min[lane*32 +: 32]);
      assign beyond = fp_less(item_t_max[lane*32 +: 32], item_t[lane*32 +: 32]);
      assign item_beyond[lane] = beyond | (wrong_comparison & item_t[lane*32 +: 32] == item_t_max[lane*32 +: 32]);
    end
  endgenerate

  // Where entries lie in sectors repeats after eight of them at most. Of the eight: the first byte, whether the entry
  // reaches the end of its sector, whether it goes beyond.
  logic [8*5-1:0] spot_byte;
  logic [7:0]     spot_completes, spot_straddles;
  always_comb begin
    for (int n = 0; n < 8; n = n + 1) begin
      spot_byte[n*5 +: 5] = 5'(byte_of(16'(n), cfg_entry_bytes));
      spot_completes[n] = {1'd0, spot_byte[n*5 +: 5]} + {1'd0, cfg_entry_bytes} >= 6'd32;
      spot_straddles[n] = straddles_at(spot_byte[n*5 +: 5], cfg_entry_bytes);
    end
  end
  function [4:0] byte_at(input [7:0] spot, input [8*5-1:0] bytes);
    byte_at = 5'd0;
    for (int n = 0; n < 8; n = n + 1) byte_at = byte_at | ({5{spot[n]}} & bytes[n*5 +: 5]);
  endfunction

  // --- Items: a prefix of them, as far as cfg_lanes and the room in the write queue go. What an item needs is worked
  // out as if all before it were taken, for else it is not. Counts are one-hot, bit n for n so far, so that to count on
  // is one choice. What is known last, whether a sector leaves the queue, chooses between results that are there.
  localparam PUSHES = 2 * LANES < WRITE_QUEUE ? 2 * LANES : WRITE_QUEUE;  // most at an edge
  localparam AHEAD_BITS = $clog2(LANES + 1);
  logic [LANES-1:0]      item_stored;              // an entry that is written
  logic [LANES*16-1:0]   new_offset;
  logic [LANES*256-1:0]  new_open;
  logic [2*LANES-1:0]    push;                     // two sectors an item at most
  logic [2*LANES*48-1:0] push_address;
  logic [2*LANES*32-1:0] push_mask;
  logic [2*LANES*256-1:0] push_data;
  logic [2*LANES*PLACE_BITS-1:0] push_place;
  // Places behind the last sector in the queue, one after the other; whether n sectors have room, and had it before
  // this edge; whether one item more may be taken after n, and two.
  logic [PUSHES*PLACE_BITS-1:0] free_place;
  logic [PUSHES:0]       room_for, room_before;
  logic [LANES:0]        may_take, may_take_two;
  always_comb begin
    for (int n = 0; n < PUSHES; n = n + 1)
      free_place[n*PLACE_BITS +: PLACE_BITS] =
          place(write_head, {1'b0, writes_level} + (LEVEL_BITS+1)'(n), cfg_write_queue);
    for (int n = 0; n <= PUSHES; n = n + 1)
      room_before[n] = {1'b0, writes_level} + (LEVEL_BITS+1)'(n) <= {1'b0, cfg_write_queue};
    // What leaves the queue at this edge makes room at this edge.
    room_for = room_before | ({PUSHES+1{write_sent}} & {room_before[PUSHES-1:0], 1'b1});
    for (int n = 0; n <= LANES; n = n + 1) begin
      may_take[n] = 7'(n) < cfg_lanes;
      may_take_two[n] = 7'(n) + 7'd1 < cfg_lanes;
    end
  end
  function [PLACE_BITS-1:0] chosen_place(input [PUSHES:0] pushed, input [PUSHES*PLACE_BITS-1:0] places);
    chosen_place = '0;
    for (int n = 0; n < PUSHES; n = n + 1)
      chosen_place = chosen_place | ({PLACE_BITS{pushed[n]}} & places[n*PLACE_BITS +: PLACE_BITS]);
  endfunction
  // The sector `ahead` behind one. The successor of its upper bits is there, so only the lower bits wait for `ahead`.
  function [47:0] sector_ahead(input [47:5] sector, input [47:5+AHEAD_BITS] successor, input [AHEAD_BITS-1:0] ahead);
    logic carry;
    logic [AHEAD_BITS-1:0] low;
    {carry, low} = {1'b0, sector[5 +: AHEAD_BITS]} + {1'b0, ahead};
    sector_ahead = {carry ? successor : sector[47:5+AHEAD_BITS], low, 5'd0};
  endfunction

  logic [PUSHES:0]       pushed, between, wanted, pushes;  // sectors; pushes: whether at least n are
  logic [LANES:0]        spent, ended, rays_done;  // items, rays that end; rays_done: whether at least n are
  logic                  walking, same, wide, complete, open_left, sends_one, sends_other, affords, goes_on;
  logic [RAY_BITS-1:0]   ray, previous;
  logic [7:0]            spot;                      // the next entry's number modulo 8, one-hot
  logic [15:0]           begun, offset;
  logic [AHEAD_BITS-1:0] entries, crossed;  // of the ray at this edge: entries so far, sectors that they complete
  logic [47:0]           start;
  logic [47:5+AHEAD_BITS] successor;
  logic [4:0]            at, end_at;
  logic [255:0]          opened, merged;
  logic [511:0]          placed;
  logic [63:0]           placed_mask;
  always_comb begin
    pushed = (PUSHES+1)'(1);
    spent = (LANES+1)'(1);
    ended = (LANES+1)'(1);
    pushes = (PUSHES+1)'(1);
    rays_done = (LANES+1)'(1);
    walking = 1'b1;
    previous = '0;
    {spot, entries, crossed, opened} = '0;
    {ray, same, wide, complete, open_left, sends_one, sends_other, affords, goes_on} = '0;
    {begun, offset, start, successor, at, end_at, merged, placed, placed_mask, between, wanted} = '0;
    for (int i = 0; i < LANES; i = i + 1) begin
      ray = item_ray[i*RAY_BITS +: RAY_BITS];
      same = i != 0 && ray == previous;
      previous = ray;
      begun = destination_offset[ray];
      if (!same) begin
        spot = 8'd1 << begun[2:0];
        entries = '0;
        crossed = '0;
        opened = open_sectors[ray];
      end
      offset = begun + 16'(entries);
      start = (item_parity[i] ? base1[47:0] : base0[47:0]) + item_offset[i*48 +: 48] +
              {27'd0, byte_of(begun, cfg_entry_bytes)};
      successor = start[47:5+AHEAD_BITS] + 1'b1;
      at = byte_at(spot, spot_byte);
      wide = (spot & spot_straddles) != 0;
      item_stored[i] = item_entry[i] & item_beyond[i] & ~item_before[i];
      complete = item_stored[i] & (spot & spot_completes) != 0;
      placed = {288'd0, item_data[i*224 +: 224]} << {at, 3'd0};
      placed_mask = {36'd0, bytes_of_entry(cfg_entry_bytes)} << at;
      merged = (opened & bits_of(below(at))) | (placed[255:0] & bits_of(placed_mask[31:0]));
      // The first sector that it sends, and where.
      sends_one = item_stored[i] & (~cfg_write_combine | complete) & ~(loses_entry & offset == 16'd3);
      push_place[(2*i)*PLACE_BITS +: PLACE_BITS] = chosen_place(pushed, free_place);
      push_address[(2*i)*48 +: 48] = sector_ahead(start[47:5], successor, crossed);
      push_mask[(2*i)*32 +: 32] = cfg_write_combine ? 32'hffffffff : placed_mask[31:0];
      push_data[(2*i)*256 +: 256] = cfg_write_combine ? merged : placed[255:0];
      if (item_stored[i]) begin
        opened = complete ? placed[511:256] : merged;
        spot = {spot[6:0], spot[7]};
        entries = entries + 1'b1;
        crossed = crossed + AHEAD_BITS'(complete);
      end
      new_offset[i*16 +: 16] = begun + 16'(entries) + {15'd0, wrong_offset & item_stored[i] & offset == 16'd3};
      new_open[i*256 +: 256] = opened;
      end_at = byte_at(spot, spot_byte);
      // The second sector: the other one of an entry, or what is open at the end of the round. A ray that hands over
      // nothing else has paid for it already.
      open_left = cfg_write_combine & item_end[i] & item_last[i] & end_at != 0;
      sends_other = cfg_write_combine ? open_left : item_stored[i] & wide;
      between = sends_one ? pushed << 1 : pushed;
      push_place[(2*i+1)*PLACE_BITS +: PLACE_BITS] = chosen_place(between, free_place);
      push_address[(2*i+1)*48 +: 48] = sector_ahead(start[47:5], successor, crossed);
      push_mask[(2*i+1)*32 +: 32] = cfg_write_combine ? below(end_at) : placed_mask[63:32];
      push_data[(2*i+1)*256 +: 256] = cfg_write_combine ? opened : placed[511:256];
      // One place for each sector that an item may complete.
      wanted = ~cfg_write_combine & item_entry[i] & cfg_entry_bytes[2] ? pushed << 2 : pushed << 1;
      walking = walking & item_valid[i] & (spent & may_take) != 0 & (wanted & room_for) != 0;
      affords = ~item_entry[i] | ((spent & may_take_two) != 0 & ((between << 1) & room_for) != 0);
      goes_on = walking & (~open_left | affords);
      item_ready[i] = walking;
      item_straddles[i] = walking & item_stored[i] & wide;
      item_done[i] = goes_on & item_end[i];
      push[2*i] = walking & sends_one;
      push[2*i+1] = sends_other & goes_on;
      pushes = pushes | ({PUSHES+1{push[2*i]}} & (pushed << 1)) | ({PUSHES+1{push[2*i+1]}} & (between << 1));
      rays_done = rays_done | ({LANES+1{item_done[i]}} & (ended << 1));
      pushed = sends_other ? between << 1 : between;
      spent = open_left & item_entry[i] ? spent << 2 : spent << 1;
      ended = item_end[i] ? ended << 1 : ended;
      walking = goes_on;
    end
  end
  // The queues after this edge: what each count would lead to, of which the count chooses.
  logic [(PUSHES+2)*LEVEL_BITS-1:0] writes_levels;  // with one sector less, as many, one more, ...
  logic [PUSHES:0]        exact_pushes;
  logic [LANES:0]         exact_done;
  logic [LEVEL_BITS-1:0]  new_writes_level;
  logic [WRITE_QUEUE-1:0] new_queued;
  logic [RAY_BITS-1:0]    new_submitted_head;
  logic [RAY_BITS:0]      new_submitted_level;
  always_comb begin
    exact_pushes = pushes & ~(pushes >> 1);
    exact_done = rays_done & ~(rays_done >> 1);
    for (int n = 0; n < PUSHES + 2; n = n + 1)
      writes_levels[n*LEVEL_BITS +: LEVEL_BITS] = writes_level + LEVEL_BITS'(n) - LEVEL_BITS'(1);
    new_writes_level = '0;
    for (int n = 0; n <= PUSHES; n = n + 1) begin
      new_writes_level = new_writes_level |
          ({LEVEL_BITS{exact_pushes[n] & write_sent}} & writes_levels[n*LEVEL_BITS +: LEVEL_BITS]) |
          ({LEVEL_BITS{exact_pushes[n] & ~write_sent}} & writes_levels[(n+1)*LEVEL_BITS +: LEVEL_BITS]);
    end
    new_queued = queued & ~({WRITE_QUEUE{write_sent}} & (WRITE_QUEUE'(1) << write_head));
    for (int n = 0; n < PUSHES; n = n + 1) begin
      new_queued = new_queued | ({WRITE_QUEUE{pushes[n+1]}} &
                                 (WRITE_QUEUE'(1) << free_place[n*PLACE_BITS +: PLACE_BITS]));
    end
    new_submitted_head = '0;
    new_submitted_level = '0;
    for (int n = 0; n <= LANES; n = n + 1) begin
      new_submitted_head = new_submitted_head | ({RAY_BITS{exact_done[n]}} & (submitted_head + RAY_BITS'(n)));
      new_submitted_level = new_submitted_level |
          ({RAY_BITS+1{exact_done[n]}} &
           (submitted_level + {{RAY_BITS{1'b0}}, submitting} - (RAY_BITS+1)'(n)));
    end
  end

  // --- Reading.
  logic [15:0] read_offset;
  logic [20:0] read_begin, part_begin;
  logic read_held, reading;
  assign read_offset = source_offset[read_ray];
  assign read_begin = byte_of(read_offset, cfg_entry_bytes);
  assign read_held = cfg_read_buffer & read_begin[4:0] != 0;
  assign read_straddles = straddles_at(read_begin[4:0], cfg_entry_bytes);
  assign read_refused = ~replay_flag[read_ray] | read_offset >= size;
  assign read_done = read_held & ~read_straddles & ~read_refused;
  assign read_ready = ~rsp_valid;  // parts have one way out
  assign rsp_ready = 1'b1;
  assign reading = read_valid & read_ready & ~read_refused;
  // The read that will be at the front when the one there leaves: the one behind it, or the one that comes at this
  // edge. The sector that ends with the entry before is held, so of two only the second is requested.
  logic ahead_queued, ahead_held, ahead_straddles;
  logic [15:0] ahead_offset;
  logic [4:0]  ahead_at;
  logic [47:0] ahead_address;
  assign ahead_queued = reads_level > 1;
  assign look_ray = ahead_queued ? reads[reads_head + 1'b1] : read_ray;
  assign ahead_offset = ahead_queued ? source_offset[reads[reads_head + 1'b1]] - 16'd1 : read_offset;
  assign ahead_at = 5'(byte_of({11'd0, ahead_offset[4:0]}, cfg_entry_bytes));
  assign ahead_held = cfg_read_buffer & ahead_at != 0;
  assign ahead_straddles = straddles_at(ahead_at, cfg_entry_bytes);
  assign ahead_address = (look_parity ? base0[47:0] : base1[47:0]) + look_offset +
                         {27'd0, byte_of(ahead_offset, cfg_entry_bytes)} + {42'd0, ahead_held, 5'd0};
  // Parts: of a sector that has come, of the one that the ray holds, or of both.
  logic arrived, part_straddles, part_held, second;
  logic [255:0] held;
  logic [511:0] window;
  logic [63:0] known;
  assign arrived = rsp_valid & ~rsp_write;
  assign second = rsp_tag[RAY_BITS];
  assign part_ray = rsp_valid ? rsp_tag[RAY_BITS-1:0] : read_ray;
  assign part_begin = rsp_valid ? byte_of(source_offset[part_ray] - 16'd1, cfg_entry_bytes) : read_begin;
  assign part_straddles = straddles_at(part_begin[4:0], cfg_entry_bytes);
  assign part_held = cfg_read_buffer & part_begin[4:0] != 0;
  assign held = cfg_read_buffer ? read_sectors[part_ray] : '0;
  assign window = {rsp_data, arrived & ~second ? rsp_data : held};
  assign known = {{32{arrived & second}}, {32{(arrived & ~second) | part_held}}};
  assign part_data = 224'(window >> {part_begin[4:0], 3'd0});
  assign part_mask = 28'(known >> part_begin[4:0]) & bytes_of_entry(cfg_entry_bytes);
  assign part_valid = arrived | (reading & read_done);
  assign part_done = arrived ? ~halves[part_ray] : read_done;

  logic [RAY_BITS:0] reads_with, new_reads_level;
  assign reads_with = reads_level + {{RAY_BITS{1'b0}}, reading & ~read_done};
  assign new_reads_level = read_leaves ? reads_with - 1'b1 : reads_with;

  assign busy = submitted_level != 0 | reads_level != 0 | writes_level != 0;
  assign idle = ~busy & outstanding == 0;

  always_ff @(posedge clk) begin
    if (rst) begin
      base0 <= cfg_base0;
      base1 <= cfg_base1;
      size <= cfg_size;
      submitted_head <= '0;
      submitted_level <= '0;
      reads_head <= '0;
      reads_level <= '0;
      write_head <= '0;
      writes_level <= '0;
      queued <= '0;
      halves <= '0;
      outstanding <= '0;
    end else begin
      submitted_head <= new_submitted_head;
      submitted_level <= new_submitted_level;
      if (read_leaves) reads_head <= reads_head + 1'b1;
      reads_level <= new_reads_level;
      if (write_sent) write_head <= place(write_head, 1, cfg_write_queue);
      queued <= new_queued;
      writes_level <= new_writes_level;
      if (reading & ~read_done) halves[read_ray] <= read_straddles & ~read_held;
      if (arrived & halves[part_ray]) halves[part_ray] <= 1'b0;
      outstanding <= outstanding + {15'd0, requested} - {15'd0, rsp_valid};
    end
  end

  // What reset leaves as it is.
  always_ff @(posedge clk) begin
    if (reads_level == 0 | read_leaves) begin
      next_sector <= ahead_address[47:5];
      next_second <= ahead_held;
      next_last <= ahead_held | ~ahead_straddles;
    end else if (read_sent) begin
      next_sector <= next_sector + 1'b1;
      next_second <= 1'b1;
      next_last <= 1'b1;
    end
    if (begin_valid) begin
      source_offset[begin_ray] <= 16'd0;
      destination_offset[begin_ray] <= 16'd0;
      replay_flag[begin_ray] <= begin_replay;
    end
    if (submit_valid & submit_overflow) replay_flag[submit_ray] <= 1'b0;
    if (submitting) submitted[submitted_head + submitted_level[RAY_BITS-1:0]] <= submit_ray;
    if (reading) source_offset[read_ray] <= read_offset + 16'd1;
    if (reading & ~read_done) reads[reads_head + reads_level[RAY_BITS-1:0]] <= read_ray;
    // When a ray has several items, the last one counts.
    for (int i = 0; i < LANES; i = i + 1) begin
      if (item_ready[i]) begin
        destination_offset[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_offset[i*16 +: 16];
        if (cfg_write_combine) open_sectors[item_ray[i*RAY_BITS +: RAY_BITS]] <= new_open[i*256 +: 256];
      end
    end
    for (int i = 0; i < 2 * LANES; i = i + 1) begin
      if (push[i]) begin
        write_address[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_address[i*48 +: 48];
        write_mask[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_mask[i*32 +: 32];
        write_data[push_place[i*PLACE_BITS +: PLACE_BITS]] <= push_data[i*256 +: 256];
      end
    end
    if (cfg_read_buffer & arrived & (second | ~part_straddles)) read_sectors[part_ray] <= rsp_data;
  end
endmodule
