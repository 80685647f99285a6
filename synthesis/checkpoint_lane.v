// The arithmetic of one checkpoint lane, as modules/checkpoint_unit.cpp counts it: t_hit against t_min and t_max, source
// and destination address = base + 20 x offset, both offsets incremented and held against the buffer's size.
module checkpoint_lane(input [31:0] t_hit, input [31:0] t_min, input [31:0] t_max, input [63:0] source_base,
                       input [63:0] destination_base, input [15:0] source_offset, input [15:0] destination_offset,
                       input [15:0] size, output before, output beyond, output [63:0] source, output [63:0] destination,
                       output [15:0] next_source, output [15:0] next_destination, output source_left,
                       output destination_room);
  fp_less at_begin(.a(t_hit), .b(t_min), .y(before));
  fp_less at_end(.a(t_max), .b(t_hit), .y(beyond));
  // x 20 = x 16 + x 4: one adder.
  assign source = source_base + ({source_offset, 4'd0} + {source_offset, 2'd0});
  assign destination = destination_base + ({destination_offset, 4'd0} + {destination_offset, 2'd0});
  assign next_source = source_offset + 16'd1;
  assign next_destination = destination_offset + 16'd1;
  assign source_left = source_offset < size;
  assign destination_room = destination_offset < size;
endmodule
